#include "robsim/vision/pixels/yuv_planes.hpp"

#include <cstddef>
#include <cstring>

#include "robsim/base/simd/cpu_path.hpp"
#include "robsim/vision/color/color_class.hpp"
#include "robsim/vision/pixels/yuv_avx2.hpp"
#include "robsim/vision/pixels/yuv_avx512.hpp"

namespace robsim::pixels {

namespace {

void convert_row_baseline(const std::uint8_t* rgb, int first, int last,
                          std::uint8_t* const* planes) {
  for (int u = first; u < last; ++u) {
    const Yuv yuv = rgb_to_yuv(rgb + std::ptrdiff_t{3} * u);
    const int values[] = {yuv.y, yuv.u, yuv.v};
    for (int channel = 0; channel < 3; ++channel) {
      if (planes[channel]) planes[channel][u] = static_cast<std::uint8_t>(values[channel]);
    }
  }
}

#if ROBSIM_HAS_AVX2_CODE
ROBSIM_AVX2_INLINE void convert_32(const std::uint8_t* rgb, int u, std::uint8_t* const* planes) {
  __m256i yuv[3];
  convert_block(rgb, planes[0] != nullptr, yuv);
  for (int channel = 0; channel < 3; ++channel) {
    if (planes[channel]) simd::store(yuv[channel], planes[channel] + u);
  }
}

ROBSIM_AVX2 void convert_row_avx2(const std::uint8_t* rgb, int first, int last,
                                  std::uint8_t* const* planes) {
  int u = first;
  for (; u + 32 <= last; u += 32) {
    const std::uint8_t* pixels = rgb + std::ptrdiff_t{3} * u;
    if (u % 64 == 0) prefetch(pixels);
    convert_32(pixels, u, planes);
  }
  if (u == last) return;
  std::uint8_t padded[96] = {};
  std::memcpy(padded, rgb + std::ptrdiff_t{3} * u,
              std::size_t{3} * static_cast<std::size_t>(last - u));
  convert_32(padded, u, planes);
}
#endif

#if ROBSIM_HAS_AVX512_CODE
ROBSIM_AVX512_INLINE void convert_64(const std::uint8_t* rgb, int u, std::uint8_t* const* planes) {
  __m512i yuv[3];
  convert_block_of_64(rgb, planes[0] != nullptr, yuv);
  for (int channel = 0; channel < 3; ++channel) {
    if (planes[channel]) simd::store(yuv[channel], planes[channel] + u);
  }
}

ROBSIM_AVX512 void convert_row_avx512(const std::uint8_t* rgb, int first, int last,
                                      std::uint8_t* const* planes) {
  int u = first;
  for (; u + 64 <= last; u += 64) {
    const std::uint8_t* pixels = rgb + std::ptrdiff_t{3} * u;
    prefetch(pixels);
    convert_64(pixels, u, planes);
  }
  if (u == last) return;
  std::uint8_t padded[192] = {};
  std::memcpy(padded, rgb + std::ptrdiff_t{3} * u,
              std::size_t{3} * static_cast<std::size_t>(last - u));
  convert_64(padded, u, planes);
}
#endif

}  // namespace

void convert_to_planes(const std::uint8_t* rgb, int first, int last, std::uint8_t* const* planes) {
  ROBSIM_PICK(convert_row_baseline, convert_row_avx2, convert_row_avx512)(rgb, first, last, planes);
}

}  // namespace robsim::pixels
