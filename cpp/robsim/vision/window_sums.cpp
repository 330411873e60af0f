#include "robsim/vision/window_sums.hpp"

#include "robsim/cpu/cpu_path.hpp"
#include "robsim/vision/bit_row.hpp"

#if ROBSIM_HAS_AVX2_CODE
#include <immintrin.h>
#endif

namespace robsim {

namespace {

using Sum = WindowSums::Sum;

// Loops that a compiler does many numbers at a time, compiled for every path.

ROBSIM_INLINE void exchange_body(const std::uint8_t* in, const std::uint8_t* out, std::size_t count,
                                 Sum* columns) {
  for (std::size_t i = 0; i < count; ++i) {
    columns[i] = static_cast<Sum>(columns[i] + in[i] - out[i]);
  }
}

template <int window>
ROBSIM_INLINE void add_up_body(const Sum* columns, std::size_t count, Sum* sums) {
  for (std::size_t i = 0; i < count; ++i) {
    Sum sum = 0;
    for (int j = 0; j < window; ++j) sum = static_cast<Sum>(sum + columns[i + std::size_t(j)]);
    sums[i] = sum;
  }
}

void exchange_plain(const std::uint8_t* in, const std::uint8_t* out, std::size_t count,
                    Sum* columns) {
  exchange_body(in, out, count, columns);
}

template <int window>
void add_up_plain(const Sum* columns, std::size_t count, Sum* sums) {
  add_up_body<window>(columns, count, sums);
}

// Bit i = lower <= sum i <= upper, for 64 sums
std::uint64_t within_plain(const Sum* sums, Sum lower, Sum upper) {
  std::uint8_t is_within[64];
  for (int i = 0; i < 64; ++i) {
    is_within[i] = static_cast<std::uint8_t>((sums[i] >= lower) & (sums[i] <= upper));
  }
  return packed(is_within);
}

#if ROBSIM_HAS_AVX2_CODE
ROBSIM_AVX2 void exchange_avx2(const std::uint8_t* in, const std::uint8_t* out, std::size_t count,
                               Sum* columns) {
  exchange_body(in, out, count, columns);
}

template <int window>
ROBSIM_AVX2 void add_up_avx2(const Sum* columns, std::size_t count, Sum* sums) {
  add_up_body<window>(columns, count, sums);
}

// 16 numbers of all bits or none
ROBSIM_AVX2_INLINE __m256i is_within(const Sum* sums, __m256i lower, __m256i range) {
  const __m256i above =
      _mm256_sub_epi16(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(sums)), lower);
  return _mm256_cmpeq_epi16(_mm256_min_epu16(above, range), above);
}

ROBSIM_AVX2 std::uint64_t within_avx2(const Sum* sums, Sum lower, Sum upper) {
  const __m256i least = _mm256_set1_epi16(static_cast<short>(lower));
  const __m256i range = _mm256_set1_epi16(static_cast<short>(upper - lower));
  std::uint64_t word = 0;
  for (int i = 0; i < 64; i += 32) {
    const __m256i bytes = _mm256_packs_epi16(is_within(sums + i, least, range),
                                             is_within(sums + i + 16, least, range));
    const __m256i in_order = _mm256_permute4x64_epi64(bytes, 0b11011000);  // packing joins lanes
    word |= std::uint64_t{static_cast<std::uint32_t>(_mm256_movemask_epi8(in_order))} << i;
  }
  return word;
}
#endif

template <int window>
WindowSums loops_of() {
#if ROBSIM_HAS_AVX2_CODE
  if (cpu_path() == CpuPath::avx2) return {exchange_avx2, add_up_avx2<window>, within_avx2};
#endif
  return {exchange_plain, add_up_plain<window>, within_plain};
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

}  // namespace robsim
