#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "robsim/base/simd/avx.hpp"
#include "robsim/vision/color/color_class.hpp"

namespace robsim::pixels {

// Prefetches 64 pixels about one row ahead. Rows are nearly always contiguous; where they are not,
// this costs nothing.
ROBSIM_INLINE void prefetch([[maybe_unused]] const std::uint8_t* rgb) {
#if ROBSIM_HAS_AVX2_CODE
  constexpr std::uintptr_t ahead = 4096;
  const std::uintptr_t address = reinterpret_cast<std::uintptr_t>(rgb) + ahead;
  for (std::uintptr_t line = 0; line < 192; line += 64) {
    _mm_prefetch(reinterpret_cast<const char*>(address + line), _MM_HINT_T0);
  }
#endif
}

// Y, U and V of 64 pixels to 64 bytes of a plane each; null skips a channel.
using Planes = std::uint8_t* const[3];

inline void convert_64(const std::uint8_t* rgb, Planes& planes) {
  for (int i = 0; i < 64; ++i) {
    const Yuv yuv = rgb_to_yuv(rgb + 3 * i);
    if (planes[0]) planes[0][i] = static_cast<std::uint8_t>(yuv.y);
    if (planes[1]) planes[1][i] = static_cast<std::uint8_t>(yuv.u);
    if (planes[2]) planes[2][i] = static_cast<std::uint8_t>(yuv.v);
  }
}

}  // namespace robsim::pixels

#if ROBSIM_HAS_AVX2_CODE

namespace robsim::pixels {

// 16 pixels: 8 in each lane, as pairs of bytes (r, g) and (b, 0).
struct Pairs {
  __m256i rg;
  __m256i b0;
};

// Each lane holds 24 bytes of pixels, loaded as bytes 0..15 and 8..23.
ROBSIM_AVX2_INLINE Pairs pairs(const std::uint8_t* low, const std::uint8_t* high) {
  const __m256i first = simd::load_halves(low, high);
  const __m256i second = simd::load_halves(low + 8, high + 8);
  const __m256i rg_of_first = _mm256_broadcastsi128_si256(
      _mm_setr_epi8(0, 1, 3, 4, 6, 7, 9, 10, 12, 13, -1, -1, -1, -1, -1, -1));
  const __m256i rg_of_second = _mm256_broadcastsi128_si256(
      _mm_setr_epi8(-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, 7, 8, 10, 11, 13, 14));
  const __m256i b_of_first = _mm256_broadcastsi128_si256(
      _mm_setr_epi8(2, -1, 5, -1, 8, -1, 11, -1, 14, -1, -1, -1, -1, -1, -1, -1));
  const __m256i b_of_second = _mm256_broadcastsi128_si256(
      _mm_setr_epi8(-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, 9, -1, 12, -1, 15, -1));
  return {_mm256_or_si256(_mm256_shuffle_epi8(first, rg_of_first),
                          _mm256_shuffle_epi8(second, rg_of_second)),
          _mm256_or_si256(_mm256_shuffle_epi8(first, b_of_first),
                          _mm256_shuffle_epi8(second, b_of_second))};
}

// (wr r + wg g + wb b) >> 7, 16 bits per pixel
ROBSIM_AVX2_INLINE __m256i weighted(const Pairs& pixels, int wr, int wg, int wb) {
  const auto weights = static_cast<short>((wr & 0xFF) | ((wg & 0xFF) << 8));
  const __m256i sum =
      _mm256_add_epi16(_mm256_maddubs_epi16(pixels.rg, _mm256_set1_epi16(weights)),
                       _mm256_maddubs_epi16(pixels.b0, _mm256_set1_epi16(short(wb & 0xFF))));
  return _mm256_srai_epi16(sum, 7);
}

// Y, U and V of 32 pixels; Y only where it is needed.
ROBSIM_AVX2_INLINE void convert_block(const std::uint8_t* rgb, bool needs_y, __m256i* yuv) {
  // Packing works within halves: pixels 0..7 and 16..23 are joined with 8..15 and 24..31.
  const Pairs even = pairs(rgb, rgb + 48);
  const Pairs odd = pairs(rgb + 24, rgb + 72);
  const __m256i neutral = _mm256_set1_epi8(static_cast<char>(128));
  if (needs_y) {
    yuv[0] = _mm256_packus_epi16(weighted(even, 38, 75, 15), weighted(odd, 38, 75, 15));
  }
  yuv[1] = _mm256_add_epi8(
      neutral, _mm256_packs_epi16(weighted(even, -22, -42, 64), weighted(odd, -22, -42, 64)));
  yuv[2] = _mm256_add_epi8(
      neutral, _mm256_packs_epi16(weighted(even, 64, -54, -10), weighted(odd, 64, -54, -10)));
}

ROBSIM_AVX2 inline void convert_64_avx2(const std::uint8_t* rgb, Planes& planes) {
  for (int half = 0; half < 64; half += 32) {
    __m256i yuv[3];
    convert_block(rgb + 3 * half, planes[0] != nullptr, yuv);
    for (int channel = 0; channel < 3; ++channel) {
      if (planes[channel]) simd::store(yuv[channel], planes[channel] + half);
    }
  }
}

}  // namespace robsim::pixels

#endif

#if ROBSIM_HAS_AVX512_CODE

namespace robsim::pixels {

// Places in two registers of 64 bytes, the second one counted from 64.
using Places = std::array<std::uint8_t, 64>;

// Where the pairs (channel, channel + 1) of 32 pixels lie in two registers that hold the first and
// the last 64 of their 96 bytes.
constexpr Places places_of_pairs(std::size_t channel) {
  Places places{};
  for (std::size_t i = 0; i < 64; ++i) {
    const std::size_t byte = 3 * (i / 2) + channel + i % 2;
    places[i] = static_cast<std::uint8_t>(byte < 64 ? byte : byte + 32);
  }
  return places;
}

constexpr Places places_of_high_bytes() {
  Places places{};
  for (std::size_t i = 0; i < 64; ++i) places[i] = static_cast<std::uint8_t>(2 * i + 1);
  return places;
}

constexpr Places rg_places = places_of_pairs(0);
constexpr Places b_places = places_of_pairs(2);
constexpr Places high_bytes = places_of_high_bytes();

// 32 pixels as pairs of bytes (r, g) and (b, 0).
struct WidePairs {
  __m512i rg;
  __m512i b0;
};

ROBSIM_AVX512_INLINE WidePairs pairs_of_32(const std::uint8_t* rgb) {
  const __m512i first = simd::load_wide(rgb);
  const __m512i last = simd::load_wide(rgb + 32);
  constexpr __mmask64 even_bytes = 0x5555555555555555;
  return {
      _mm512_permutex2var_epi8(first, simd::load_wide(rg_places.data()), last),
      _mm512_maskz_permutex2var_epi8(even_bytes, first, simd::load_wide(b_places.data()), last)};
}

// 2 (wr r + wg g + wb b), 16 bits per pixel, whose high byte is the sum >> 7
ROBSIM_AVX512_INLINE __m512i weighted(const WidePairs& pixels, int wr, int wg, int wb) {
  const auto weights = static_cast<short>((wr & 0xFF) | ((wg & 0xFF) << 8));
  const __m512i sum =
      _mm512_add_epi16(_mm512_maddubs_epi16(pixels.rg, _mm512_set1_epi16(weights)),
                       _mm512_maddubs_epi16(pixels.b0, _mm512_set1_epi16(short(wb & 0xFF))));
  return _mm512_add_epi16(sum, sum);
}

ROBSIM_AVX512_INLINE __m512i weighted_64(const WidePairs& low, const WidePairs& high, int wr,
                                         int wg, int wb) {
  return _mm512_permutex2var_epi8(weighted(low, wr, wg, wb), simd::load_wide(high_bytes.data()),
                                  weighted(high, wr, wg, wb));
}

ROBSIM_AVX512 inline void convert_64_avx512(const std::uint8_t* rgb, Planes& planes) {
  const WidePairs low = pairs_of_32(rgb);
  const WidePairs high = pairs_of_32(rgb + 96);
  const __m512i neutral = _mm512_set1_epi8(static_cast<char>(128));
  if (planes[0]) simd::store(weighted_64(low, high, 38, 75, 15), planes[0]);
  if (planes[1]) {
    simd::store(_mm512_xor_si512(neutral, weighted_64(low, high, -22, -42, 64)), planes[1]);
  }
  if (planes[2]) {
    simd::store(_mm512_xor_si512(neutral, weighted_64(low, high, 64, -54, -10)), planes[2]);
  }
}

}  // namespace robsim::pixels

#endif
