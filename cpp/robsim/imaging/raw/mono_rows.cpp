#include "robsim/imaging/raw/mono_rows.hpp"

#include <algorithm>

#include "robsim/base/simd/cpu_path.hpp"
#include "robsim/imaging/raw/interleave_avx2.hpp"
#include "robsim/imaging/raw/row_blocks.hpp"

namespace robsim::raw {

namespace {

void mono8_row_baseline(const std::uint8_t* raw, int width, std::uint8_t* rgb) {
  for (int u = 0; u < width; ++u, rgb += 3) rgb[0] = rgb[1] = rgb[2] = raw[u];
}

void mono16_row_baseline(const std::uint8_t* raw, int width, int bits, std::uint8_t* rgb) {
  for (int u = 0; u < width; ++u, raw += 2, rgb += 3) {
    const int grey = ((raw[0] << 8) | raw[1]) >> (bits - 8);
    rgb[0] = rgb[1] = rgb[2] = static_cast<std::uint8_t>(std::min(grey, 255));
  }
}

#if ROBSIM_HAS_AVX2_CODE

ROBSIM_AVX2 void mono8_row_avx2(const std::uint8_t* raw, int width, std::uint8_t* rgb) {
  for_each_block<8>(raw, width, rgb, [](const std::uint8_t* from, std::uint8_t* to) ROBSIM_AVX2 {
    const __m256i grey = simd::load(from);
    store_rgb(grey, grey, grey, to);
  });
}

// 8 pixels each of two places, in lanes of 16 bits.
ROBSIM_AVX2_INLINE __m256i grey_lanes(const std::uint8_t* low, const std::uint8_t* high, int bits) {
  constexpr Indices swapped = {1, 0, 3, 2, 5, 4, 7, 6, 9, 8, 11, 10, 13, 12, 15, 14};
  const __m256i grey = _mm256_shuffle_epi8(simd::load_halves(low, high), in_both_halves(swapped));
  return _mm256_min_epu16(_mm256_srl_epi16(grey, _mm_cvtsi32_si128(bits - 8)),
                          _mm256_set1_epi16(255));
}

ROBSIM_AVX2 void mono16_row_avx2(const std::uint8_t* raw, int width, int bits, std::uint8_t* rgb) {
  for_each_block<16>(
      raw, width, rgb, [bits](const std::uint8_t* from, std::uint8_t* to) ROBSIM_AVX2 {
        // Packing works within halves: pixels 0..7 and 16..23 are joined with 8..15 and 24..31.
        const __m256i grey = _mm256_packus_epi16(grey_lanes(from, from + 32, bits),
                                                 grey_lanes(from + 16, from + 48, bits));
        store_rgb(grey, grey, grey, to);
      });
}

#endif

}  // namespace

void mono8_row(const std::uint8_t* raw, int width, std::uint8_t* rgb) {
  ROBSIM_PICK(mono8_row_baseline, mono8_row_avx2)(raw, width, rgb);
}

void mono16_row(const std::uint8_t* raw, int width, int bits, std::uint8_t* rgb) {
  ROBSIM_PICK(mono16_row_baseline, mono16_row_avx2)(raw, width, bits, rgb);
}

}  // namespace robsim::raw
