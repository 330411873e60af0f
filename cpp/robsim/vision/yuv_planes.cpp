#include "robsim/vision/yuv_planes.hpp"

#include <cstddef>

#include "robsim/cpu/cpu_path.hpp"
#include "robsim/vision/color_class.hpp"
#include "robsim/vision/yuv_avx2.hpp"

namespace robsim {

namespace {

void convert_plain(const std::uint8_t* rgb, int first, int last, std::uint8_t* const* planes) {
  for (int u = first; u < last; ++u) {
    const Yuv yuv = rgb_to_yuv(rgb + std::ptrdiff_t{3} * u);
    const int values[] = {yuv.y, yuv.u, yuv.v};
    for (int channel = 0; channel < 3; ++channel) {
      if (planes[channel]) planes[channel][u] = static_cast<std::uint8_t>(values[channel]);
    }
  }
}

#if ROBSIM_HAS_AVX2_CODE
ROBSIM_AVX2 void convert_avx2(const std::uint8_t* rgb, int first, int last,
                              std::uint8_t* const* planes) {
  for (int u = first; u + 32 <= last; u += 32) {
    __m256i yuv[3];
    convert_block(rgb + std::ptrdiff_t{3} * u, planes[0] != nullptr, yuv);
    for (int channel = 0; channel < 3; ++channel) {
      if (!planes[channel]) continue;
      _mm256_storeu_si256(reinterpret_cast<__m256i*>(planes[channel] + u), yuv[channel]);
    }
  }
}
#endif

}  // namespace

void convert_to_planes(const std::uint8_t* rgb, int first, int last, std::uint8_t* const* planes) {
#if ROBSIM_HAS_AVX2_CODE
  if (cpu_path() == CpuPath::avx2) {
    convert_avx2(rgb, first, last, planes);
    first += (last - first) / 32 * 32;
  }
#endif
  convert_plain(rgb, first, last, planes);
}

}  // namespace robsim
