#include "robsim/vision/color/image_statistics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <vector>

#include "robsim/vision/color/color_class.hpp"

namespace robsim {

namespace {

constexpr int block_width = 7;  // px

struct MeanChroma {
  double u;
  double v;
};

MeanChroma mean_chroma(const ImageView& image, const PixelBox& block) {
  int u = 0;
  int v = 0;
  for (int row = block.top; row < block.bottom; ++row) {
    for (int column = block.left; column < block.right; ++column) {
      const Yuv yuv = rgb_to_yuv(image.row(row) + std::ptrdiff_t{3} * column);
      u += yuv.u;
      v += yuv.v;
    }
  }
  const double count = (block.right - block.left) * (block.bottom - block.top);
  return {u / count, v / count};
}

double percentile_of(std::vector<double>& values, double percent) {
  const auto place =
      static_cast<std::ptrdiff_t>(percent / 100 * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + place, values.end());
  return values[static_cast<std::size_t>(place)];
}

}  // namespace

SurroundingChroma surrounding_chroma(const ImageView& image) {
  std::vector<double> means[2];
  for (int top = 0; top < image.height; top += block_width) {
    for (int left = 0; left < image.width; left += block_width) {
      const MeanChroma mean =
          mean_chroma(image, {left, top, std::min(left + block_width, image.width),
                              std::min(top + block_width, image.height)});
      means[0].push_back(mean.u);
      means[1].push_back(mean.v);
    }
  }
  SurroundingChroma result{};
  for (std::size_t i = 0; i < 2; ++i) {
    result.median[i] = percentile_of(means[i], 50);
    result.spread[i] = (percentile_of(means[i], 84) - percentile_of(means[i], 16)) / 2;
  }
  return result;
}

namespace {

constexpr int places_across = 48;
constexpr int places_down = 32;

// The middle, its 4 neighbours, its corners: any plane gives 0, noise of 1 gives 6.
int second_difference(const ImageView& image, int u, int v, int channel) {
  const auto row_sum = [&](int row) {
    const std::uint8_t* pixel = image.row(row) + 3 * u + channel;
    return pixel[-3] - 2 * pixel[0] + pixel[3];
  };
  return row_sum(v - 1) - 2 * row_sum(v) + row_sum(v + 1);
}

// A pixel at the end of the range tells nothing of the noise.
bool is_clipped(std::uint8_t level) { return level == 0 || level == 255; }

}  // namespace

double grey_noise(const ImageView& image) {
  if (image.width < 3 || image.height < 3) return 0;
  std::vector<int> sizes;
  sizes.reserve(std::size_t{3} * places_across * places_down);
  const PixelBox inside{1, 1, image.width - 1, image.height - 1};
  look_at_grid(inside, places_down, places_across, [&](int u, int v) {
    for (int channel = 0; channel < 3; ++channel) {
      if (is_clipped(image.row(v)[3 * u + channel])) continue;
      sizes.push_back(std::abs(second_difference(image, u, v, channel)));
    }
  });
  if (sizes.empty()) return 0;
  // The median of |x| of a Gaussian number is 0.6745 standard deviations.
  return median_of(sizes) / (6 * 0.6745);
}

}  // namespace robsim

namespace robsim::pixels {

namespace {

constexpr int rows = 8;
constexpr int columns = 32;

}  // namespace

double chroma_noise(const ImageView& image) {
  if (image.width < 2) return 0;
  std::array<int, rows * columns> u_differences{};
  std::array<int, rows * columns> v_differences{};
  std::size_t i = 0;
  look_at_grid({0, 0, image.width - 1, image.height}, rows, columns, [&](int u, int v) {
    const std::uint8_t* rgb = image.row(v) + std::ptrdiff_t{3} * u;
    const Yuv left = rgb_to_yuv(rgb);
    const Yuv right = rgb_to_yuv(rgb + 3);
    u_differences[i] = std::abs(left.u - right.u);
    v_differences[i++] = std::abs(left.v - right.v);
  });
  // The median of |a - b| of two Gaussian numbers is 0.6745 sqrt(2) standard deviations.
  return std::max(median_of(u_differences), median_of(v_differences)) / (0.6745 * std::sqrt(2.0));
}

}  // namespace robsim::pixels
