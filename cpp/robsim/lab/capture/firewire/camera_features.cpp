#include "robsim/lab/capture/firewire/fire_wire_camera.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>

#include "robsim/lab/capture/firewire/fire_wire_bus.hpp"

namespace robsim::fire_wire {

namespace {

struct Named {
  dc1394feature_t feature;
  const char* name;
  const char* unit;  // of absolute values
};

constexpr std::array<Named, 9> named{{{DC1394_FEATURE_BRIGHTNESS, "brightness", "%"},
                                      {DC1394_FEATURE_EXPOSURE, "exposure", "EV"},
                                      {DC1394_FEATURE_SHARPNESS, "sharpness", ""},
                                      {DC1394_FEATURE_WHITE_BALANCE, "white_balance", ""},
                                      {DC1394_FEATURE_HUE, "hue", "deg"},
                                      {DC1394_FEATURE_SATURATION, "saturation", "%"},
                                      {DC1394_FEATURE_GAMMA, "gamma", ""},
                                      {DC1394_FEATURE_SHUTTER, "shutter", "s"},
                                      {DC1394_FEATURE_GAIN, "gain", "dB"}}};

// Not available, too, if the camera does not answer: many know some registers alone.
dc1394feature_info_t info_of(dc1394camera_t* camera, dc1394feature_t feature) {
  dc1394feature_info_t info{};
  info.id = feature;
  if (dc1394_feature_get(camera, &info) != DC1394_SUCCESS) info.available = DC1394_FALSE;
  return info;
}

bool has_mode(const dc1394feature_info_t& info, dc1394feature_mode_t mode) {
  const auto* const end = info.modes.modes + info.modes.num;
  return std::find(info.modes.modes, end, mode) != end;
}

FeatureState state_of(const Named& one, const dc1394feature_info_t& info) {
  FeatureState state;
  state.name = one.name;
  state.is_automatic = info.current_mode == DC1394_FEATURE_MODE_AUTO;
  state.low = info.min;
  state.high = info.max;
  if (one.feature == DC1394_FEATURE_WHITE_BALANCE) {
    state.values = {static_cast<double>(info.BU_value), static_cast<double>(info.RV_value)};
  } else if (info.absolute_capable) {
    state.values = {double{info.abs_value}};
    state.low = double{info.abs_min};
    state.high = double{info.abs_max};
    state.unit = one.unit;
  } else {
    state.values = {static_cast<double>(info.value)};
  }
  return state;
}

// Of absolute limits, which have single precision.
constexpr double slack = 1e-6;

void set_values(dc1394camera_t* camera, const Named& one, const dc1394feature_info_t& info,
                const FeatureWish& wish) {
  check_values(wish, state_of(one, info), slack);
  const std::string action = std::string("set the ") + one.name;
  const auto whole = [&](std::size_t i) {
    return static_cast<std::uint32_t>(std::lround(wish.values[i]));
  };
  if (one.feature == DC1394_FEATURE_WHITE_BALANCE) {
    check(dc1394_feature_whitebalance_set_value(camera, whole(0), whole(1)), action);
  } else if (info.absolute_capable) {
    check(dc1394_feature_set_absolute_control(camera, one.feature, DC1394_ON), action);
    check(
        dc1394_feature_set_absolute_value(camera, one.feature, static_cast<float>(wish.values[0])),
        action);
  } else {
    check(dc1394_feature_set_value(camera, one.feature, whole(0)), action);
  }
}

}  // namespace

void set_features(dc1394camera_t* camera, const std::vector<FeatureWish>& wishes) {
  for (const Named& one : named) {
    const auto wish = std::find_if(wishes.begin(), wishes.end(),
                                   [&](const FeatureWish& w) { return w.name == one.name; });
    const bool is_wished = wish != wishes.end();
    const dc1394feature_info_t info = info_of(camera, one.feature);
    if (!info.available) {
      if (!is_wished) continue;
      throw CaptureError(CaptureFault::failed,
                         std::string("features.") + one.name + ": this camera has no such feature");
    }
    const dc1394feature_mode_t mode =
        is_wished && wish->is_automatic ? DC1394_FEATURE_MODE_AUTO : DC1394_FEATURE_MODE_MANUAL;
    const std::string action = std::string("set the ") + one.name;
    if (has_mode(info, mode)) {
      check(dc1394_feature_set_mode(camera, one.feature, mode), action);
    } else if (is_wished && wish->is_automatic) {
      throw CaptureError(CaptureFault::failed, std::string("features.") + one.name +
                                                   ": this camera has no automatic one");
    }
    if (is_wished && info.on_off_capable)
      check(dc1394_feature_set_power(camera, one.feature, DC1394_ON), action);
    if (is_wished && !wish->is_automatic) set_values(camera, one, info, *wish);
  }
}

std::vector<FeatureState> features_of(dc1394camera_t* camera) {
  dc1394switch_t sends = DC1394_OFF;
  check(dc1394_video_get_transmission(camera, &sends), "ask the camera for its features");
  std::vector<FeatureState> found;
  for (const Named& one : named) {
    const dc1394feature_info_t info = info_of(camera, one.feature);
    if (info.available) found.push_back(state_of(one, info));
  }
  return found;
}

}  // namespace robsim::fire_wire
