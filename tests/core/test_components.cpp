// Connected components against a flood fill over the same pixels.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "robsim/vision/pixels/components.hpp"

namespace robsim::pixels {
namespace {

using Pattern = std::vector<std::string>;  // '#' = set
using Moments = std::tuple<std::int64_t, std::int64_t, std::int64_t, int, int, int, int>;

Moments moments_of(const Component& c) {
  return {c.area, c.sum_u, c.sum_v, c.box.left, c.box.top, c.box.right, c.box.bottom};
}

BitRow bits_of(const std::string& line) {
  BitRow row(words_of(static_cast<int>(line.size())), 0);
  for (std::size_t u = 0; u < line.size(); ++u) {
    if (line[u] == '#') row[u / 64] |= std::uint64_t{1} << (u % 64);
  }
  return row;
}

std::vector<Moments> found(ComponentFinder& finder, const Pattern& pattern, int minimum_area = 1) {
  finder.begin(minimum_area);
  for (const std::string& line : pattern) {
    finder.add_row(bits_of(line), static_cast<int>(line.size()));
  }
  std::vector<Moments> result;
  for (const Component& c : finder.finish()) result.push_back(moments_of(c));
  std::sort(result.begin(), result.end());
  return result;
}

std::vector<Moments> found(const Pattern& pattern, int minimum_area = 1) {
  ComponentFinder finder;
  return found(finder, pattern, minimum_area);
}

void flood(Pattern& pattern, int u, int v, Component& c) {
  const int width = static_cast<int>(pattern[0].size());
  const int height = static_cast<int>(pattern.size());
  if (u < 0 || v < 0 || u >= width || v >= height || pattern[v][u] != '#') return;
  pattern[v][u] = '.';
  c.area += 1;
  c.sum_u += u;
  c.sum_v += v;
  c.box = {std::min(c.box.left, u), std::min(c.box.top, v), std::max(c.box.right, u + 1),
           std::max(c.box.bottom, v + 1)};
  for (int i = 0; i < 9; ++i) flood(pattern, u + i % 3 - 1, v + i / 3 - 1, c);
}

std::vector<Moments> flooded(Pattern pattern) {
  std::vector<Moments> result;
  for (int v = 0; v < static_cast<int>(pattern.size()); ++v) {
    for (int u = 0; u < static_cast<int>(pattern[0].size()); ++u) {
      if (pattern[v][u] != '#') continue;
      Component c;
      c.box = {u, v, u + 1, v + 1};
      flood(pattern, u, v, c);
      result.push_back(moments_of(c));
    }
  }
  std::sort(result.begin(), result.end());
  return result;
}

Pattern random_pattern(std::mt19937& random, int width, int height, double density) {
  std::bernoulli_distribution is_set(density);
  Pattern pattern(height, std::string(width, '.'));
  for (std::string& line : pattern) {
    for (char& pixel : line) pixel = is_set(random) ? '#' : '.';
  }
  return pattern;
}

TEST(Components, OnePixelHasItsOwnMoments) {
  EXPECT_EQ(found({"....", "..#."}), (std::vector<Moments>{{1, 2, 1, 2, 1, 3, 2}}));
}

TEST(Components, PixelsThatTouchAtACornerAreOne) {
  EXPECT_EQ(found({"#..", ".#.", "#.."}), (std::vector<Moments>{{3, 1, 3, 0, 0, 2, 3}}));
  EXPECT_EQ(found({"..#", ".#.", "..#"}), (std::vector<Moments>{{3, 5, 3, 1, 0, 3, 3}}));
}

TEST(Components, AGapOfOnePixelSeparates) { EXPECT_EQ(found({"#.#", "#.#"}).size(), 2U); }

TEST(Components, ArmsThatMeetFurtherDownAreJoined) {
  EXPECT_EQ(found({"#.#.#.#", "#.#.#.#", "#######"}),
            (std::vector<Moments>{{15, 45, 18, 0, 0, 7, 3}}));
}

TEST(Components, AChainOfJoinsEndsAtOneRoot) {
  const Pattern pattern = {"#...#...#...#", ".#.#.....#.#.", "..#.......#..", "..#########.."};
  EXPECT_EQ(found(pattern), flooded(pattern));
  EXPECT_EQ(found(pattern).size(), 1U);
}

TEST(Components, AnEmptyRowClosesAllAndTheirSlotsAreUsedAgain) {
  const Pattern pattern = {"##.##.##", "........", ".######.", "........", "#.#.#.#."};
  EXPECT_EQ(found(pattern), flooded(pattern));
  EXPECT_EQ(found(pattern).size(), 8U);
}

TEST(Components, SmallOnesAreDroppedOnlyWhenTheyAreComplete) {
  const std::vector<Moments> large = found({"#.#", "###", "...", "##."}, 3);
  EXPECT_EQ(large, (std::vector<Moments>{{5, 5, 3, 0, 0, 3, 2}}));
}

TEST(Components, AFinderForgetsThePreviousImage) {
  ComponentFinder finder;
  found(finder, {"####", "####"});
  EXPECT_EQ(found(finder, {"#...", "...#"}), flooded({"#...", "...#"}));
}

TEST(Components, AgreeWithAFloodFillOnRandomPatterns) {
  for (const unsigned seed : {1U, 2U, 3U, 4U, 5U, 6U}) {
    for (const double density : {0.1, 0.3, 0.5, 0.7}) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", density " + std::to_string(density));
      std::mt19937 random(seed);
      const Pattern pattern = random_pattern(random, 131, 40, density);
      EXPECT_EQ(found(pattern), flooded(pattern));
    }
  }
}

// Rows of noise wait for the next one, and lose their isolated pixels: here and there.
TEST(Components, OfNoiseAreThoseThatAreLargeEnough) {
  for (const unsigned seed : {1U, 2U, 3U, 4U}) {
    for (const double density : {0.1, 0.2, 0.4}) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", density " + std::to_string(density));
      std::mt19937 random(seed);
      Pattern pattern = random_pattern(random, 200, 12, density);
      for (const double calmer : {0.01, 0.5, 0.0, 0.3}) {
        const Pattern more = random_pattern(random, 200, 5, calmer);
        pattern.insert(pattern.end(), more.begin(), more.end());
      }
      const std::vector<Moments> all = flooded(pattern);
      for (const int minimum_area : {2, 3, 9}) {
        std::vector<Moments> large;
        for (const Moments& moments : all) {
          if (std::get<0>(moments) >= minimum_area) large.push_back(moments);
        }
        EXPECT_EQ(found(pattern, minimum_area), large) << minimum_area;
      }
    }
  }
}

}  // namespace
}  // namespace robsim::pixels
