// Bit rows and their runs, across the borders of words.
#include "robsim/vision/pixels/bit_row.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <random>
#include <utility>
#include <vector>

namespace robsim::pixels {
namespace {

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

TEST(BitRow, IsWrittenBitByBit) {
  std::mt19937_64 random(1);
  for (const int width : {1, 64, 65, 200}) {
    BitRow expected(words_of(width));
    for (std::uint64_t& word : expected) word = random();
    clear_beyond(expected, width);
    BitRow row(words_of(width));
    BitWriter writer(row);
    for (int u = 0; u < width; ++u) writer.add(is_set(expected, u));
    writer.finish();
    EXPECT_EQ(row, expected) << width;
  }
}

TEST(BitRow, PacksByteIIntoBitI) {
  for (int i = 0; i < 64; ++i) {
    std::uint8_t bytes[64] = {};
    bytes[i] = 1;
    EXPECT_EQ(pack_bits(bytes), std::uint64_t{1} << i) << i;
  }
}

}  // namespace
}  // namespace robsim::pixels
