#include "robsim/vision/color/surrounding_chroma.hpp"

#include <algorithm>
#include <cstddef>
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

}  // namespace robsim
