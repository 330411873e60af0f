#pragma once

#include "robsim/base/simd/avx.hpp"

#if ROBSIM_HAS_AVX512_CODE

#include <array>
#include <cstddef>
#include <cstdint>

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

// Y, U and V of 64 pixels; Y only where it is needed.
ROBSIM_AVX512_INLINE void convert_block_of_64(const std::uint8_t* rgb, bool needs_y, __m512i* yuv) {
  const WidePairs low = pairs_of_32(rgb);
  const WidePairs high = pairs_of_32(rgb + 96);
  const __m512i neutral = _mm512_set1_epi8(static_cast<char>(128));
  if (needs_y) yuv[0] = weighted_64(low, high, 38, 75, 15);
  yuv[1] = _mm512_xor_si512(neutral, weighted_64(low, high, -22, -42, 64));
  yuv[2] = _mm512_xor_si512(neutral, weighted_64(low, high, 64, -54, -10));
}

}  // namespace robsim::pixels

#endif
