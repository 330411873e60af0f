#include "robsim/vision/pixels/smoothing.hpp"

#include <cstddef>

#include "robsim/base/simd/avx.hpp"
#include "robsim/base/simd/cpu_path.hpp"
#include "robsim/vision/pixels/bit_row.hpp"
#include "robsim/vision/pixels/yuv_avx.hpp"

namespace robsim::pixels {

namespace {

template <auto convert>
ROBSIM_INLINE void convert_row(const std::uint8_t* rgb, int first, int last,
                               std::uint8_t* const* planes) {
  PaddedRow row(rgb, last);
  for (std::size_t word = words_of(first); word < row.blocks(); ++word) {
    const std::uint8_t* const pixels = row.block(word);
    prefetch(pixels);
    const auto at = [&](int channel) {
      return planes[channel] ? planes[channel] + 64 * word : nullptr;
    };
    std::uint8_t* const of_word[3] = {at(0), at(1), at(2)};
    convert(pixels, of_word);
  }
}

}  // namespace

void convert_to_planes(const std::uint8_t* rgb, int first, int last, std::uint8_t* const* planes) {
  ROBSIM_PICK(convert_row<convert_64>, convert_row<convert_64_avx2>,
              convert_row<convert_64_avx512>)(rgb, first, last, planes);
}

namespace {

using Sum = WindowSums::Sum;
using Limits = WindowSums::Limits;

// Loops that the compiler vectorises, once for every path.

ROBSIM_INLINE void exchange(const std::uint8_t* in, const std::uint8_t* out, std::size_t count,
                            Sum* columns) {
  for (std::size_t i = 0; i < count; ++i) {
    columns[i] = static_cast<Sum>(columns[i] + in[i] - out[i]);
  }
}

template <int window>
void sum_baseline(const Sum* columns, std::size_t words, Sum* sums) {
  for (std::size_t i = 0; i < 64 * words; ++i) {
    Sum sum = 0;
    for (std::size_t j = 0; j < window; ++j) sum = static_cast<Sum>(sum + columns[i + j]);
    sums[i] = sum;
  }
}

void limit_baseline(const Sum* sums, const Limits& limits, std::size_t words, std::uint64_t* bits) {
  const Sum lower = limits.lower;
  const Sum upper = limits.upper;
  for (std::size_t word = 0; word < words; ++word) {
    if (bits[word] == 0) continue;
    std::uint8_t is_within[64];
    for (int i = 0; i < 64; ++i) {
      const Sum sum = sums[64 * word + i];
      is_within[i] = static_cast<std::uint8_t>((sum >= lower) & (sum <= upper));
    }
    bits[word] &= pack_bits(is_within);
  }
}

#if ROBSIM_HAS_AVX2_CODE

// Words n, n + 1, ... of a register and of the one that follows it in memory, 0 < n < 16
template <int n>
ROBSIM_AVX2_INLINE __m256i shifted(__m256i words, __m256i next) {
  const __m256i middle = _mm256_permute2x128_si256(words, next, 0x21);
  if constexpr (n < 8) return _mm256_alignr_epi8(middle, words, 2 * n);
  return _mm256_alignr_epi8(next, middle, 2 * n % 16);
}

// The sum of pairs 0, 2, ... n
template <int n>
ROBSIM_AVX2_INLINE __m256i sum_of_pairs(__m256i pairs, __m256i next) {
  if constexpr (n == 0) {
    return pairs;
  } else {
    return _mm256_add_epi16(sum_of_pairs<n - 2>(pairs, next), shifted<n>(pairs, next));
  }
}

ROBSIM_AVX2_INLINE __m256i pairs_from(const Sum* columns) {
  return _mm256_add_epi16(simd::load(columns), simd::load(columns + 1));
}

// Sums of pairs of neighbours, which are shifted in registers: fewer loads than columns.
template <int window>
ROBSIM_AVX2_INLINE void sum_avx2(const Sum* columns, std::size_t words, Sum* sums) {
  __m256i pairs = pairs_from(columns);
  for (std::size_t i = 0; i < 64 * words; i += 16) {
    const __m256i next = pairs_from(columns + i + 16);
    const __m256i last = simd::load(columns + i + window - 1);
    simd::store(_mm256_add_epi16(sum_of_pairs<window - 3>(pairs, next), last), sums + i);
    pairs = next;
  }
}

// Words n, n + 1, ... of a register and of the one that follows it in memory, n even
template <int n>
ROBSIM_AVX512_INLINE __m512i shifted(__m512i words, __m512i next) {
  return _mm512_alignr_epi32(next, words, n / 2);
}

template <int n>
ROBSIM_AVX512_INLINE __m512i sum_of_pairs(__m512i pairs, __m512i next) {
  if constexpr (n == 0) {
    return pairs;
  } else {
    return _mm512_add_epi16(sum_of_pairs<n - 2>(pairs, next), shifted<n>(pairs, next));
  }
}

template <int window>
ROBSIM_AVX512_INLINE void sum_avx512(const Sum* columns, std::size_t words, Sum* sums) {
  __m512i own = simd::load_wide(columns);
  __m512i pairs = _mm512_add_epi16(own, simd::load_wide(columns + 1));
  for (std::size_t i = 0; i < 64 * words; i += 32) {
    const __m512i next_own = simd::load_wide(columns + i + 32);
    const __m512i next = _mm512_add_epi16(next_own, simd::load_wide(columns + i + 33));
    const __m512i last = shifted<window - 1>(own, next_own);
    simd::store(_mm512_add_epi16(sum_of_pairs<window - 3>(pairs, next), last), sums + i);
    own = next_own;
    pairs = next;
  }
}

// 16 masks
ROBSIM_AVX2_INLINE __m256i is_within(__m256i sums, __m256i lower, __m256i range) {
  const __m256i above = _mm256_sub_epi16(sums, lower);
  return _mm256_cmpeq_epi16(_mm256_min_epu16(above, range), above);
}

ROBSIM_AVX2_INLINE void limit_avx2(const Sum* sums, const Limits& limits, std::size_t words,
                                   std::uint64_t* bits) {
  const __m256i lower = _mm256_set1_epi16(static_cast<short>(limits.lower));
  const __m256i range = _mm256_set1_epi16(static_cast<short>(limits.upper - limits.lower));
  for (std::size_t word = 0; word < words; ++word) {
    if (bits[word] == 0) continue;
    std::uint64_t within = 0;
    for (int i = 0; i < 64; i += 32) {
      const Sum* values = sums + 64 * word + i;
      const __m256i bytes = _mm256_packs_epi16(is_within(simd::load(values), lower, range),
                                               is_within(simd::load(values + 16), lower, range));
      const int mask = _mm256_movemask_epi8(simd::in_order(bytes));
      within |= std::uint64_t{static_cast<std::uint32_t>(mask)} << i;
    }
    bits[word] &= within;
  }
}

ROBSIM_AVX512_INLINE void limit_avx512(const Sum* sums, const Limits& limits, std::size_t words,
                                       std::uint64_t* bits) {
  const __m512i lower = _mm512_set1_epi16(static_cast<short>(limits.lower));
  const __m512i range = _mm512_set1_epi16(static_cast<short>(limits.upper - limits.lower));
  for (std::size_t word = 0; word < words; ++word) {
    if (bits[word] == 0) continue;
    const __m512i low = _mm512_sub_epi16(simd::load_wide(sums + 64 * word), lower);
    const __m512i high = _mm512_sub_epi16(simd::load_wide(sums + 64 * word + 32), lower);
    bits[word] &=
        _mm512_kunpackd(_mm512_cmple_epu16_mask(high, range), _mm512_cmple_epu16_mask(low, range));
  }
}

#endif

template <int window>
WindowSums loops_of() {
  return {ROBSIM_PICK(exchange, exchange, exchange),
          ROBSIM_PICK(sum_baseline<window>, sum_avx2<window>, sum_avx512<window>),
          ROBSIM_PICK(limit_baseline, limit_avx2, limit_avx512)};
}

}  // namespace

WindowSums window_sums(int window) {
  constexpr WindowSums (*loops[])() = {loops_of<3>, loops_of<3>,  loops_of<5>,  loops_of<7>,
                                       loops_of<9>, loops_of<11>, loops_of<13>, loops_of<15>};
  return loops[window / 2]();
}

}  // namespace robsim::pixels
