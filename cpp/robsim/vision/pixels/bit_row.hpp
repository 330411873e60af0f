#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#ifdef _MSC_VER
#include <intrin.h>
#endif

namespace robsim::pixels {

/// One bit per pixel, 64 pixels per word, the first in the lowest bit; bits beyond the row are 0.
using BitRow = std::vector<std::uint64_t>;

inline std::size_t words_of(int width) { return (static_cast<std::size_t>(width) + 63) / 64; }

inline bool is_set(const BitRow& row, int u) {
  return (row[static_cast<std::size_t>(u) / 64] >> (u % 64)) & 1;
}

/// The position of the lowest set bit. Precondition: word != 0.
inline int lowest_bit(std::uint64_t word) {
#ifdef _MSC_VER
  unsigned long position = 0;
  _BitScanForward64(&position, word);
  return static_cast<int>(position);
#else
  return __builtin_ctzll(word);
#endif
}

/// Packs 64 bytes, each 0 or 1, into a word.
inline std::uint64_t pack_bits(const std::uint8_t* bytes) {
  std::uint64_t word = 0;
  for (int i = 0; i < 64; i += 8) {
    std::uint64_t eight = 0;
    for (int j = 0; j < 8; ++j) eight |= std::uint64_t{bytes[i + j]} << (8 * j);
    // The product moves bit 8 j, that of byte j, to bit 56 + j.
    word |= (eight * 0x0102040810204080ULL) >> 56 << i;
  }
  return word;
}

/// Clears the bits beyond the row in its last word.
inline void clear_beyond(std::vector<BitRow>& rows, int width) {
  if (width % 64 == 0) return;
  for (BitRow& row : rows) row.back() &= (std::uint64_t{1} << (width % 64)) - 1;
}

/// Is no bit set? Most rows of a frame without noise are empty.
inline bool is_empty(const BitRow& row) {
  std::uint64_t any = 0;
  for (const std::uint64_t word : row) any |= word;
  return any == 0;
}

/// Calls f(left, right) for each run left <= u < right of set bits.
template <typename F>
void for_each_run(const BitRow& row, int width, F&& f) {
  if (is_empty(row)) return;
  std::uint64_t previous = 0;  // the last bit of the previous word
  int left = 0;
  for (std::size_t i = 0; i < row.size(); ++i) {
    const std::uint64_t word = row[i];
    if ((word | previous) == 0) continue;
    // A bit that differs from its predecessor begins or ends a run.
    std::uint64_t edges = word ^ ((word << 1) | previous);
    previous = word >> 63;
    for (; edges != 0; edges &= edges - 1) {
      const int bit = lowest_bit(edges);
      const int u = static_cast<int>(64 * i) + bit;
      if ((word >> bit) & 1) {
        left = u;
      } else {
        f(left, u);
      }
    }
  }
  if (previous) f(left, width);
}

}  // namespace robsim::pixels
