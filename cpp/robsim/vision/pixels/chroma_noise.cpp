#include "robsim/vision/pixels/chroma_noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "robsim/vision/color/color_class.hpp"

namespace robsim::pixels {

namespace {

constexpr int rows = 8;
constexpr int columns = 32;

double median(std::array<int, rows * columns>& values) {
  const auto middle = values.begin() + values.size() / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

double chroma_noise(const ImageView& image) {
  if (image.width < 2) return 0;
  std::array<int, rows * columns> u_differences{};
  std::array<int, rows * columns> v_differences{};
  std::size_t i = 0;
  for (int row = 0; row < rows; ++row) {
    const std::uint8_t* pixels = image.row(row * (image.height - 1) / (rows - 1));
    for (int column = 0; column < columns; ++column, ++i) {
      const std::uint8_t* rgb = pixels + 3 * (column * (image.width - 2) / (columns - 1));
      const Yuv left = rgb_to_yuv(rgb);
      const Yuv right = rgb_to_yuv(rgb + 3);
      u_differences[i] = std::abs(left.u - right.u);
      v_differences[i] = std::abs(left.v - right.v);
    }
  }
  // The median of |a - b| of two Gaussian numbers is 0.6745 sqrt(2) standard deviations.
  return std::max(median(u_differences), median(v_differences)) / (0.6745 * std::sqrt(2.0));
}

}  // namespace robsim::pixels
