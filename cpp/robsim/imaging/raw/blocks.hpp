#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "robsim/base/simd/avx.hpp"
#include "robsim/base/simd/target.hpp"
#include "robsim/imaging/raw/pixel_format.hpp"

namespace robsim::raw {

/// Turns a Bayer frame of 2 x 2 px at least into RGB8.
void convert_bayer(const RawView& raw, const WritableView& rgb);

/// Pixels that one step of a loop in vectors converts.
constexpr int pixels_of_block = 32;

/// Calls convert(raw, rgb) for blocks of 32 pixels of a row, whose raw bytes are `bits` for each
/// pixel. It may read up to 6 bytes beyond the block: the last block is a copy with room.
template <int bits, typename Convert>
ROBSIM_INLINE void for_each_block(const std::uint8_t* raw, int width, std::uint8_t* rgb,
                                  Convert&& convert) {
  constexpr std::size_t bytes = pixels_of_block * bits / 8;
  int left = width;
  for (; left > pixels_of_block; left -= pixels_of_block) {
    convert(raw, rgb);
    raw += bytes;
    rgb += 3 * pixels_of_block;
  }
  std::uint8_t padded[bytes + 6] = {};
  std::uint8_t result[3 * pixels_of_block];
  std::memcpy(padded, raw, static_cast<std::size_t>(left * bits / 8));
  convert(padded, result);
  std::memcpy(rgb, result, std::size_t{3} * static_cast<std::size_t>(left));
}

}  // namespace robsim::raw

#if ROBSIM_HAS_AVX2_CODE

namespace robsim::raw {

using Indices = std::array<std::int8_t, 16>;

/// The same 16 bytes in both halves of a register.
ROBSIM_AVX2_INLINE __m256i in_both_halves(const Indices& bytes) {
  return _mm256_broadcastsi128_si256(
      _mm_loadu_si128(reinterpret_cast<const __m128i*>(bytes.data())));
}

// 16 pixels are 48 bytes, three chunks of 16: byte 3 i + c is channel c of pixel i. A shuffle takes
// it to place (3 i + c) mod 16, the one that it has in its chunk; as 3 and 16 have no common
// divisor, no two pixels meet there.
template <int channel>
constexpr Indices places_of_channel = [] {
  Indices from{};
  for (int i = 0; i < 16; ++i) {
    from[static_cast<std::size_t>((3 * i + channel) % 16)] = static_cast<std::int8_t>(i);
  }
  return from;
}();

// -1 where a byte of a chunk is of a channel
template <int chunk, int channel>
constexpr Indices is_of_channel = [] {
  Indices is{};
  for (int i = 0; i < 16; ++i) {
    is[static_cast<std::size_t>(i)] = (16 * chunk + i) % 3 == channel ? -1 : 0;
  }
  return is;
}();

template <int chunk>
ROBSIM_AVX2_INLINE __m256i chunk_of(__m256i r, __m256i g, __m256i b) {
  const __m256i r_or_g = _mm256_blendv_epi8(r, g, in_both_halves(is_of_channel<chunk, 1>));
  return _mm256_blendv_epi8(r_or_g, b, in_both_halves(is_of_channel<chunk, 2>));
}

/// Writes 32 pixels of RGB8 of their channels.
ROBSIM_AVX2_INLINE void store_rgb(__m256i r, __m256i g, __m256i b, std::uint8_t* rgb) {
  r = _mm256_shuffle_epi8(r, in_both_halves(places_of_channel<0>));
  g = _mm256_shuffle_epi8(g, in_both_halves(places_of_channel<1>));
  b = _mm256_shuffle_epi8(b, in_both_halves(places_of_channel<2>));
  const __m256i first = chunk_of<0>(r, g, b);
  const __m256i second = chunk_of<1>(r, g, b);
  const __m256i third = chunk_of<2>(r, g, b);
  // The low halves are the chunks of pixels 0..15, the high ones those of pixels 16..31.
  simd::store(_mm256_permute2x128_si256(first, second, 0x20), rgb);
  simd::store(_mm256_permute2x128_si256(third, first, 0x30), rgb + 32);
  simd::store(_mm256_permute2x128_si256(second, third, 0x31), rgb + 64);
}

}  // namespace robsim::raw

#endif
