#include "robsim/imaging/grey_noise.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

namespace robsim {

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
  for (int i = 0; i < places_down; ++i) {
    const int v = 1 + i * (image.height - 3) / (places_down - 1);
    for (int j = 0; j < places_across; ++j) {
      const int u = 1 + j * (image.width - 3) / (places_across - 1);
      for (int channel = 0; channel < 3; ++channel) {
        if (is_clipped(image.row(v)[3 * u + channel])) continue;
        sizes.push_back(std::abs(second_difference(image, u, v, channel)));
      }
    }
  }
  if (sizes.empty()) return 0;
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  // The median of |x| of a Gaussian number is 0.6745 standard deviations.
  return *middle / (6 * 0.6745);
}

}  // namespace robsim
