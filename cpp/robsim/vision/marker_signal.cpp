#include "robsim/vision/marker_signal.hpp"

#include <algorithm>
#include <cmath>

#include "robsim/base/elementary/elementary.hpp"
#include "robsim/base/geometry.hpp"

namespace robsim {

namespace {

constexpr double good_contrast = 150;  // of red and blue on black; root of the squares over R, G, B
constexpr double sharp_edge = 0.6;     // frame px
constexpr double all_edge = 4.5;       // frame px; narrower markers stand out less
constexpr double least_width = 2;      // frame px
constexpr double rounding_noise = 0.3;  // levels: every picture has it

// Of markers of the width all_edge.
double signal_there(double noise) {
  const double perimeter = 2 * std::sqrt(pi) * all_edge;
  const double ratio = good_contrast / std::max(noise, rounding_noise);
  return std::sqrt(2 * ratio * ratio * perimeter * sharp_edge / 3.5);
}

}  // namespace

double expected_signal_to_noise(double width, double noise) {
  const double share = width / all_edge;
  const double is_seen = share < 1 ? share * share : 1;  // measured: rates of detection
  return signal_there(noise) * std::sqrt(share) * is_seen;
}

double trusted_width(double noise) {
  const double ratio = trusted_signal_to_noise / signal_there(noise);
  const double power = ratio < 1 ? 1 / 2.5 : 2;
  return std::max(least_width, all_edge * elementary::exp(power * elementary::log(ratio)));
}

}  // namespace robsim
