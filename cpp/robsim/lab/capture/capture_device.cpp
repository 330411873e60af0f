#include "robsim/lab/capture/capture_device.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

namespace robsim {

namespace {

constexpr std::array<std::pair<const char*, CaptureFault>, 10> faults{{
    {"no_back_end", CaptureFault::no_back_end},
    {"no_bus", CaptureFault::no_bus},
    {"no_permission", CaptureFault::no_permission},
    {"no_camera", CaptureFault::no_camera},
    {"no_bandwidth", CaptureFault::no_bandwidth},
    {"busy", CaptureFault::busy},
    {"time_out", CaptureFault::time_out},
    {"unplugged", CaptureFault::unplugged},
    {"end", CaptureFault::end},
    {"failed", CaptureFault::failed},
}};

}  // namespace

CaptureFault fault_of(const std::string& name) {
  for (const auto& [key, fault] : faults) {
    if (name == key) return fault;
  }
  return CaptureFault::failed;
}

const char* name_of(CaptureFault fault) {
  for (const auto& [key, value] : faults) {
    if (value == fault) return key;
  }
  return "failed";
}

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
