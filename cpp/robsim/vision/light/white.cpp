#include "robsim/vision/light/white.hpp"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace robsim::light {

namespace {

constexpr int places = 32;       // pixels looked at, in each direction
constexpr int darkest_told = 4;  // levels
constexpr float largest_gain = 4;

}  // namespace

std::array<int, 3> floor_color(const ImageView& image) {
  std::array<int, 3> color{};
  std::vector<std::uint8_t> values(places * places);
  for (int channel = 0; channel < 3; ++channel) {
    auto value = values.begin();
    for (int i = 0; i < places; ++i) {
      const std::uint8_t* row = image.row(i * (image.height - 1) / (places - 1));
      for (int j = 0; j < places; ++j) {
        *value++ = row[3 * (j * (image.width - 1) / (places - 1)) + channel];
      }
    }
    const auto middle = values.begin() + places * places / 2;
    std::nth_element(values.begin(), middle, values.end());
    color[static_cast<std::size_t>(channel)] = *middle;
  }
  return color;
}

Gains gains_to_grey(const std::array<int, 3>& color) {
  const auto [least, most] = std::minmax_element(color.begin(), color.end());
  if (*least < darkest_told) return {1, 1, 1};
  Gains gains{};
  for (std::size_t i = 0; i < 3; ++i) {
    gains[i] = std::min(static_cast<float>(*most) / static_cast<float>(color[i]), largest_gain);
  }
  return gains;
}

}  // namespace robsim::light
