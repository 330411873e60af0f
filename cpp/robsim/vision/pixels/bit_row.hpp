#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#ifdef _MSC_VER
#include <intrin.h>
#endif

#include "robsim/base/simd/avx.hpp"

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
ROBSIM_INLINE std::uint64_t pack_bits(const std::uint8_t* bytes) {
  std::uint64_t word = 0;
#if ROBSIM_HAS_AVX2_CODE
  for (int i = 0; i < 64; i += 16) {  // instructions of SSE2, which every x86-64 has
    const __m128i is_set =
        _mm_slli_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(bytes + i)), 7);
    word |= std::uint64_t{static_cast<std::uint32_t>(_mm_movemask_epi8(is_set))} << i;
  }
#else
  for (int i = 0; i < 64; i += 8) {
    std::uint64_t eight = 0;
    for (int j = 0; j < 8; ++j) eight |= std::uint64_t{bytes[i + j]} << (8 * j);
    // The product moves bit 8 j, that of byte j, to bit 56 + j.
    word |= (eight * 0x0102040810204080ULL) >> 56 << i;
  }
#endif
  return word;
}

/// Clears the bits beyond the row in its last word.
inline void clear_beyond(BitRow& row, int width) {
  if (width % 64 != 0) row.back() &= (std::uint64_t{1} << (width % 64)) - 1;
}

inline void clear_beyond(std::vector<BitRow>& rows, int width) {
  for (BitRow& row : rows) clear_beyond(row, width);
}

/// Makes a row of so many bits, all of them set.
inline void set_all(BitRow& row, int width) {
  row.assign(words_of(width), ~std::uint64_t{0});
  clear_beyond(row, width);
}

/// Are all bits of a row of this width set?
inline bool is_full(const BitRow& row, int width) {
  std::uint64_t all = ~std::uint64_t{0};
  for (std::size_t i = 0; i + 1 < row.size(); ++i) all &= row[i];
  return all == ~std::uint64_t{0} && row.back() == ~std::uint64_t{0} >> ((64 - width % 64) % 64);
}

/// result[i] = bits[i - 1] | bits[i] | bits[i + 1]
inline void widen(const BitRow& bits, int width, BitRow& result) {
  result.resize(bits.size());
  for (std::size_t i = 0; i < bits.size(); ++i) {
    const std::uint64_t before = i > 0 ? bits[i - 1] >> 63 : 0;
    const std::uint64_t after = i + 1 < bits.size() ? bits[i + 1] << 63 : 0;
    result[i] = bits[i] | (bits[i] << 1) | before | (bits[i] >> 1) | after;
  }
  clear_beyond(result, width);
}

/// The bits of a row but those with none beside them, in their row or in the rows above and below
/// (8 neighbours). All three are equally long.
inline void drop_isolated(const BitRow& above, const BitRow& row, const BitRow& below,
                          BitRow& result) {
  result.resize(row.size());
  std::uint64_t before = 0;  // the last bit of any row in the previous word
  for (std::size_t i = 0; i < row.size(); ++i) {
    const std::uint64_t others = above[i] | below[i];
    const std::uint64_t any = others | row[i];
    const bool is_last = i + 1 == row.size();
    const std::uint64_t next = is_last ? 0 : above[i + 1] | below[i + 1] | row[i + 1];
    result[i] = row[i] & (others | (any << 1) | before | (any >> 1) | (next << 63));
    before = any >> 63;
  }
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

/// A row of RGB8 pixels in blocks of 64. The last block is padded with black, so that a byte beyond
/// any block may be read.
class PaddedRow {
 public:
  PaddedRow(const std::uint8_t* rgb, int width)
      : rgb_(rgb),
        last_(words_of(width) - 1),
        remainder_(3 * (static_cast<std::size_t>(width) - 64 * last_)) {}

  std::size_t blocks() const { return last_ + 1; }

  /// The last block is copied on demand only: by then the pixels before it are in the cache.
  const std::uint8_t* block(std::size_t word) {
    if (word < last_) return rgb_ + 192 * word;
    std::memcpy(padded_, rgb_ + 192 * last_, remainder_);
    std::memset(padded_ + remainder_, 0, sizeof padded_ - remainder_);
    return padded_;
  }

 private:
  const std::uint8_t* rgb_;
  std::size_t last_;
  std::size_t remainder_;  // bytes in the last block
  std::uint8_t padded_[193];
};

}  // namespace robsim::pixels
