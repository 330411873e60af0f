// Bit rows across the borders of words, and connected components against a flood fill.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <random>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "robsim/vision/pixels/bit_row.hpp"
#include "robsim/vision/pixels/components.hpp"

namespace robsim::pixels {
namespace {

// --- bit rows

using Runs = std::vector<std::pair<int, int>>;

void set(BitRow& row, int left, int right) {
  for (int u = left; u < right; ++u) {
    row[static_cast<std::size_t>(u / 64)] |= std::uint64_t{1} << (u % 64);
  }
}

Runs runs_of(const BitRow& row, int width) {
  Runs runs;
  for_each_run(row, width, [&](int left, int right) { runs.emplace_back(left, right); });
  return runs;
}

Runs runs_pixel_by_pixel(const BitRow& row, int width) {
  Runs runs;
  for (int u = 0; u < width; ++u) {
    if (!is_set(row, u)) continue;
    if (u == 0 || !is_set(row, u - 1)) runs.emplace_back(u, u);
    runs.back().second = u + 1;
  }
  return runs;
}

TEST(BitRow, HasAWordForEvery64Pixels) {
  EXPECT_EQ(words_of(1), 1U);
  EXPECT_EQ(words_of(64), 1U);
  EXPECT_EQ(words_of(65), 2U);
}

TEST(BitRow, RunsMayBeginEndAndContinueAtTheBordersOfWords) {
  const Runs expected = {{0, 1}, {63, 65}, {70, 128}, {130, 192}, {193, 256}};
  BitRow row(words_of(256), 0);
  for (const auto& [left, right] : expected) set(row, left, right);
  EXPECT_EQ(runs_of(row, 256), expected);
}

TEST(BitRow, ARunOverAllWordsIsOneRun) {
  BitRow row(words_of(192), 0);
  set(row, 0, 192);
  EXPECT_EQ(runs_of(row, 192), (Runs{{0, 192}}));
}

TEST(BitRow, RunsAgreeWithAScanPixelByPixel) {
  for (const unsigned seed : {1U, 2U, 3U, 4U}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    for (const int width : {1, 63, 64, 65, 200}) {
      BitRow row(words_of(width));
      for (std::uint64_t& word : row) word = random() | (random() & random());
      std::vector<BitRow> rows = {row};
      clear_beyond(rows, width);
      EXPECT_EQ(runs_of(rows[0], width), runs_pixel_by_pixel(rows[0], width)) << width;
    }
  }
}

TEST(BitRow, ClearsTheBitsBeyondTheRowAndNoOthers) {
  std::vector<BitRow> rows = {BitRow(2, ~std::uint64_t{0}), BitRow(2, 0)};
  clear_beyond(rows, 67);
  EXPECT_EQ(rows[0], (BitRow{~std::uint64_t{0}, 0b111}));
  EXPECT_EQ(rows[1], (BitRow{0, 0}));
  rows[0].back() = ~std::uint64_t{0};
  clear_beyond(rows, 128);
  EXPECT_EQ(rows[0].back(), ~std::uint64_t{0});
}

TEST(BitRow, SetsAllBitsOfARowAndKnowsThatItIsFull) {
  for (const int width : {1, 63, 64, 65, 128, 130}) {
    BitRow row;
    set_all(row, width);
    EXPECT_EQ(runs_of(row, width), (Runs{{0, width}})) << width;
    EXPECT_TRUE(is_full(row, width)) << width;
    for (const int u : {0, width / 2, width - 1}) {
      BitRow other = row;
      other[static_cast<std::size_t>(u) / 64] ^= std::uint64_t{1} << (u % 64);
      EXPECT_FALSE(is_full(other, width)) << width << ", " << u;
    }
  }
}

TEST(BitRow, WidensEachBitByItsNeighboursWithinTheRow) {
  for (const int width : {1, 2, 63, 64, 65, 130}) {
    for (const int u : {0, 1, 62, 63, 64, 65, 127, 128, 129}) {
      if (u >= width) continue;
      BitRow row(words_of(width), 0);
      row[static_cast<std::size_t>(u) / 64] = std::uint64_t{1} << (u % 64);
      BitRow wide;
      widen(row, width, wide);
      EXPECT_EQ(runs_of(wide, width), (Runs{{std::max(0, u - 1), std::min(width, u + 2)}}))
          << width << ", " << u;
      EXPECT_EQ(wide.back() >> ((width - 1) % 64) >> 1, 0U) << width << ", " << u;
    }
  }
}

TEST(BitRow, LosesBitsThatHaveNoneBesideThem) {
  constexpr int width = 130;
  for (const int u : {0, 1, 62, 63, 64, 65, 127, 128, 129}) {
    BitRow row(words_of(width), 0);
    set(row, u, u + 1);
    const BitRow none(words_of(width), 0);
    BitRow result;
    drop_isolated(none, row, none, result);
    EXPECT_TRUE(is_empty(result)) << u;
    for (int other = 0; other < width; ++other) {
      BitRow with_other(words_of(width), 0);
      set(with_other, other, other + 1);
      const bool is_beside = std::abs(other - u) <= 1;
      drop_isolated(with_other, row, none, result);
      EXPECT_EQ(is_set(result, u), is_beside) << u << ", " << other << " above";
      drop_isolated(none, row, with_other, result);
      EXPECT_EQ(is_set(result, u), is_beside) << u << ", " << other << " below";
      if (other == u) continue;
      set(with_other, u, u + 1);
      drop_isolated(none, with_other, none, result);
      EXPECT_EQ(result, is_beside ? with_other : none) << u << ", " << other << " in the row";
    }
  }
}

TEST(BitRow, PacksByteIIntoBitI) {
  for (int i = 0; i < 64; ++i) {
    std::uint8_t bytes[64] = {};
    bytes[i] = 1;
    EXPECT_EQ(pack_bits(bytes), std::uint64_t{1} << i) << i;
  }
}

// --- components

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
