#include "robsim/lab/capture/camera_feature.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "robsim/lab/capture/capture_device.hpp"

namespace robsim {

namespace {

std::string text_of(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

}  // namespace

std::vector<FeatureWish> overlaid(const std::vector<FeatureWish>& earlier,
                                  const std::vector<FeatureWish>& later) {
  std::vector<FeatureWish> all = later;
  for (const FeatureWish& wish : earlier) {
    const bool is_replaced = std::any_of(later.begin(), later.end(),
                                         [&](const FeatureWish& w) { return w.name == wish.name; });
    if (!is_replaced) all.push_back(wish);
  }
  return all;
}

void check_values(const FeatureWish& wish, const FeatureState& state, double slack) {
  const std::size_t wanted = state.values.size();
  const double room = slack * std::max(std::abs(state.low), std::abs(state.high));
  const bool fits = wish.values.size() == wanted &&
                    std::all_of(wish.values.begin(), wish.values.end(), [&](double value) {
                      return value >= state.low - room && value <= state.high + room;
                    });
  if (fits) return;
  std::string got;
  for (const double value : wish.values) got += (got.empty() ? "" : ", ") + text_of(value);
  throw CaptureError(CaptureFault::failed,
                     "features." + wish.name + " must be " +
                         (wanted == 2 ? "two numbers (blue, red) " : "a number ") + "from " +
                         text_of(state.low) + " to " + text_of(state.high) +
                         (state.unit.empty() ? "" : " " + state.unit) + " on this camera, got " +
                         got);
}

}  // namespace robsim
