#include "robsim/vision/light/relative_class.hpp"

#include <algorithm>
#include <cstddef>

namespace robsim::light {

namespace {

constexpr int neutral_level = 128;

// The limit of the shipped classes (levels from neutral), and the brightest channel at which it is
// a saturation s of 29 %: |V - 128| = s R/2 of a red, |U - 128| = s B/2 of a blue.
constexpr float full_limit = 26;
constexpr float full_brightness = 180;

// How far from neutral the nearest colour of the class is in its stricter channel (levels).
int distance_from_grey(const ColorClass& color) {
  int distance = 0;
  for (std::size_t i = 1; i < 3; ++i) {
    distance = std::max({distance, color.lower[i] - neutral_level, neutral_level - color.upper[i]});
  }
  return distance;
}

}  // namespace

std::optional<RelativeClass> relative_to_brightness(const ColorClass& color, float least_chroma) {
  const auto distance = static_cast<float>(distance_from_grey(color));
  if (distance == 0 || color.lower[0] > 0 || color.upper[0] < 255) return std::nullopt;
  const float brightness = full_brightness * std::min(distance / full_limit, 1.0F);
  RelativeClass result{};
  for (std::size_t i = 0; i < 2; ++i) {
    // An open end stays open: no colour is farther from neutral than its brightest channel.
    const auto limit = [&](int level, int open) {
      const auto from_neutral = static_cast<float>(level - neutral_level);
      return level == open ? (open == 0 ? -2.0F : 2.0F) : from_neutral / brightness;
    };
    result.lower[i] = limit(color.lower[i + 1], 0);
    result.upper[i] = limit(color.upper[i + 1], 255);
  }
  // distance/brightness darkest = least_chroma
  result.darkest = least_chroma * brightness / distance;
  return result;
}

}  // namespace robsim::light
