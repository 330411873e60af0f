#include "robsim/vision/pixels/window_sums.hpp"

#include "robsim/simd/avx2.hpp"
#include "robsim/simd/cpu_path.hpp"

namespace robsim::pixels {

namespace {

using Sum = WindowSums::Sum;
using Limits = WindowSums::Limits;
using Columns = WindowSums::Columns;

// A loop that the compiler vectorises, once for every path.

ROBSIM_INLINE void exchange_body(const std::uint8_t* in, const std::uint8_t* out, std::size_t count,
                                 Sum* columns) {
  for (std::size_t i = 0; i < count; ++i) {
    columns[i] = static_cast<Sum>(columns[i] + in[i] - out[i]);
  }
}

void exchange_baseline(const std::uint8_t* in, const std::uint8_t* out, std::size_t count,
                       Sum* columns) {
  exchange_body(in, out, count, columns);
}

// Bit i is set if sum i of 64 lies within the limits.
std::uint64_t within_baseline(const Sum* sums, const Limits& limits) {
  const Sum lower = limits.lower;
  const Sum upper = limits.upper;
  std::uint8_t is_within[64];
  for (int i = 0; i < 64; ++i) {
    is_within[i] = static_cast<std::uint8_t>((sums[i] >= lower) & (sums[i] <= upper));
  }
  return pack_bits(is_within);
}

template <int window>
void classify_baseline(const Columns& columns, std::size_t first, std::size_t last,
                       const std::vector<std::vector<Limits>>& classes, std::vector<BitRow>& bits) {
  Sum sums[3][64];
  for (std::size_t word = first; word < last; ++word) {
    for (std::size_t channel = 0; channel < 3; ++channel) {
      if (!columns[channel]) continue;
      for (std::size_t i = 0; i < 64; ++i) {
        Sum sum = 0;
        for (std::size_t j = 0; j < window; ++j) {
          sum = static_cast<Sum>(sum + columns[channel][64 * word + i + j]);
        }
        sums[channel][i] = sum;
      }
    }
    for (std::size_t i = 0; i < classes.size(); ++i) {
      std::uint64_t members = ~std::uint64_t{0};
      for (const Limits& limits : classes[i]) {
        if (members != 0) members &= within_baseline(sums[limits.channel], limits);
      }
      bits[i][word] = members;
    }
  }
}

#if ROBSIM_HAS_AVX2_CODE
ROBSIM_AVX2 void exchange_avx2(const std::uint8_t* in, const std::uint8_t* out, std::size_t count,
                               Sum* columns) {
  exchange_body(in, out, count, columns);
}

// 16 masks
ROBSIM_AVX2_INLINE __m256i is_within(__m256i sums, __m256i lower, __m256i range) {
  const __m256i above = _mm256_sub_epi16(sums, lower);
  return _mm256_cmpeq_epi16(_mm256_min_epu16(above, range), above);
}

ROBSIM_AVX2_INLINE std::uint64_t within_avx2(const __m256i* sums, const Limits& limits) {
  const __m256i lower = _mm256_set1_epi16(static_cast<short>(limits.lower));
  const __m256i range = _mm256_set1_epi16(static_cast<short>(limits.upper - limits.lower));
  std::uint64_t word = 0;
  for (int i = 0; i < 4; i += 2) {
    const __m256i bytes =
        _mm256_packs_epi16(is_within(sums[i], lower, range), is_within(sums[i + 1], lower, range));
    const int mask = _mm256_movemask_epi8(simd::in_order(bytes));
    word |= std::uint64_t{static_cast<std::uint32_t>(mask)} << (16 * i);
  }
  return word;
}

template <int window>
ROBSIM_AVX2 void classify_avx2(const Columns& columns, std::size_t first, std::size_t last,
                               const std::vector<std::vector<Limits>>& classes,
                               std::vector<BitRow>& bits) {
  __m256i sums[3][4];
  for (std::size_t word = first; word < last; ++word) {
    for (std::size_t channel = 0; channel < 3; ++channel) {
      if (!columns[channel]) continue;
      for (std::size_t i = 0; i < 4; ++i) {
        const Sum* column = columns[channel] + 64 * word + 16 * i;
        __m256i sum = simd::load(column);
        for (std::size_t j = 1; j < window; ++j)
          sum = _mm256_add_epi16(sum, simd::load(column + j));
        sums[channel][i] = sum;
      }
    }
    for (std::size_t i = 0; i < classes.size(); ++i) {
      std::uint64_t members = ~std::uint64_t{0};
      for (const Limits& limits : classes[i]) {
        if (members != 0) members &= within_avx2(sums[limits.channel], limits);
      }
      bits[i][word] = members;
    }
  }
}
#endif

template <int window>
WindowSums loops_of() {
  return {ROBSIM_PICK(exchange_baseline, exchange_avx2),
          ROBSIM_PICK(classify_baseline<window>, classify_avx2<window>)};
}

}  // namespace

WindowSums window_sums(int window) {
  switch (window) {
    case 3:
      return loops_of<3>();
    case 5:
      return loops_of<5>();
    case 7:
      return loops_of<7>();
    case 9:
      return loops_of<9>();
    case 11:
      return loops_of<11>();
    case 13:
      return loops_of<13>();
    default:
      return loops_of<15>();
  }
}

}  // namespace robsim::pixels
