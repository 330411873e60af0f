#include "robsim/vision/pixels/relative_classifier.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "robsim/base/simd/cpu_path.hpp"

namespace robsim::light {

namespace {

constexpr int places = 32;       // pixels looked at, in each direction
constexpr int darkest_told = 4;  // levels
constexpr float largest_gain = 4;

}  // namespace

std::array<int, 3> floor_color(const ImageView& image) {
  std::vector<std::uint8_t> values[3];
  look_at_grid({0, 0, image.width, image.height}, places, places, [&](int u, int v) {
    for (int c = 0; c < 3; ++c) values[c].push_back(image.row(v)[3 * u + c]);
  });
  return {median_of(values[0]), median_of(values[1]), median_of(values[2])};
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

namespace {

using Sum = pixels::WindowSums::Sum;

// Loops that the compiler vectorises, once for every path. No sum of several numbers is in them
// whose order it might choose, so all paths give the same bits.

ROBSIM_INLINE void sum_window(const Sum* columns, std::size_t count, int window, Sum* sums) {
  std::copy_n(columns, count, sums);
  for (int j = 1; j < window; ++j) {
    const Sum* shifted = columns + 3 * j;
    for (std::size_t i = 0; i < count; ++i) sums[i] = static_cast<Sum>(sums[i] + shifted[i]);
  }
}

struct Balanced {
  float* u;           // U - 128
  float* v;           // V - 128
  float* brightness;  // the largest of R, G and B
};

ROBSIM_INLINE void balance(const Sum* sums, std::size_t width, const Gains& factors,
                           const Balanced& result) {
  for (std::size_t i = 0; i < width; ++i) {
    const float r = factors[0] * static_cast<float>(sums[3 * i]);
    const float g = factors[1] * static_cast<float>(sums[3 * i + 1]);
    const float b = factors[2] * static_cast<float>(sums[3 * i + 2]);
    const float of_r_and_g = r > g ? r : g;
    result.brightness[i] = of_r_and_g > b ? of_r_and_g : b;
    // as rgb_to_yuv
    result.u[i] = (64 * b - 22 * r - 42 * g) / 128;
    result.v[i] = (64 * r - 54 * g - 10 * b) / 128;
  }
}

// Whether lower <= chroma/brightness <= upper for U and V, of 64 pixels.
ROBSIM_INLINE void members_of(const float* u, const float* v, const float* brightness,
                              const RelativeClass& limits, std::uint8_t* is_member) {
  for (std::size_t i = 0; i < 64; ++i) {
    const float scale = brightness[i] > limits.darkest ? brightness[i] : limits.darkest;
    is_member[i] = static_cast<std::uint8_t>(
        (u[i] >= limits.lower[0] * scale) & (u[i] <= limits.upper[0] * scale) &
        (v[i] >= limits.lower[1] * scale) & (v[i] <= limits.upper[1] * scale));
  }
}

}  // namespace

RelativeClassifier::RelativeClassifier(const ImageView& image,
                                       std::vector<std::optional<RelativeClass>> classes,
                                       int window, const Gains& gains)
    : image_(image), classes_(std::move(classes)), window_(window), factors_(gains) {
  for (float& factor : factors_) factor /= static_cast<float>(window * window);
  const auto width = static_cast<std::size_t>(image.width);
  const std::size_t words = pixels::words_of(image.width);
  columns_.resize(3 * (width + static_cast<std::size_t>(window - 1)));
  sums_.resize(3 * width);
  for (std::vector<float>* plane : {&chroma_[0], &chroma_[1], &brightness_}) {
    plane->resize(64 * words);
  }
  bits_.assign(classes_.size(), pixels::BitRow(words));
  const std::vector<std::uint8_t> zeros(3 * width);
  for (int v = -(window / 2); v <= window / 2; ++v) exchange(row(v), zeros.data());
}

const std::uint8_t* RelativeClassifier::row(int v) const {
  return image_.row(std::clamp(v, 0, image_.height - 1));
}

void RelativeClassifier::exchange(const std::uint8_t* in, const std::uint8_t* out) {
  const auto count = 3 * static_cast<std::size_t>(image_.width);
  Sum* columns = columns_.data() + 3 * (window_ / 2);
  pixels::window_sums(window_).exchange(in, out, count, columns);
}

const std::vector<pixels::BitRow>& RelativeClassifier::next_row() {
  const int margin = window_ / 2;
  if (v_ > 0) exchange(row(v_ + margin), row(v_ - 1 - margin));
  ++v_;
  const auto width = static_cast<std::size_t>(image_.width);
  Sum* columns = columns_.data() + 3 * margin;
  for (int i = 1; i <= margin; ++i) {
    std::copy_n(columns, 3, columns - 3 * i);
    std::copy_n(columns + 3 * (width - 1), 3, columns + 3 * (width - 1 + i));
  }
  ROBSIM_PICK(sum_window)(columns_.data(), 3 * width, window_, sums_.data());
  const Balanced balanced{chroma_[0].data(), chroma_[1].data(), brightness_.data()};
  ROBSIM_PICK(balance)(sums_.data(), width, factors_, balanced);
  const auto members = ROBSIM_PICK(members_of);
  std::uint8_t is_member[64];
  for (std::size_t i = 0; i < classes_.size(); ++i) {
    if (!classes_[i]) continue;
    for (std::size_t word = 0; word < bits_[i].size(); ++word) {
      members(balanced.u + 64 * word, balanced.v + 64 * word, balanced.brightness + 64 * word,
              *classes_[i], is_member);
      bits_[i][word] = pixels::pack_bits(is_member);
    }
  }
  pixels::clear_beyond(bits_, image_.width);
  return bits_;
}

}  // namespace robsim::light
