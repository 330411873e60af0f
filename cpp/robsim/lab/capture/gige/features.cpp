#include "robsim/lab/capture/gige/settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>

#include "robsim/lab/capture/capture_device.hpp"

namespace robsim::gige {

namespace {

// Names of the Standard Features Naming Convention of GenICam, and those of older cameras.
struct Named {
  const char* name;                    // ours
  const char* automatic;               // its switch; null: there is none
  std::array<const char*, 3> genicam;  // the first one that the camera has
  const char* unit;
  double scale = 1;  // of GenICam's unit in ours
};

constexpr std::array<Named, 8> named{{
    {"shutter", "ExposureAuto", {"ExposureTime", "ExposureTimeAbs"}, "s", 1e6},
    {"gain", "GainAuto", {"Gain", "GainRaw", "GainAbs"}, ""},
    {"white_balance", "BalanceWhiteAuto", {"BalanceRatio", "BalanceRatioAbs"}, ""},
    {"brightness", "BlackLevelAuto", {"BlackLevel", "BlackLevelRaw"}, ""},
    {"gamma", nullptr, {"Gamma"}, ""},
    {"saturation", nullptr, {"Saturation"}, ""},
    {"hue", nullptr, {"Hue"}, ""},
    {"sharpness", nullptr, {"Sharpness"}, ""},
}};

[[noreturn]] void refuse(const Named& one, const std::string& text) {
  throw CaptureError(CaptureFault::failed, std::string("features.") + one.name + text);
}

bool is_pair(const Named& one) { return one.automatic && !std::strcmp(one.name, "white_balance"); }

// Which of the two values comes next: blue, red.
void select(ArvCamera* camera, const Named& one, std::size_t i) {
  if (!is_pair(one)) return;
  GFailure failure;
  arv_camera_set_string(camera, "BalanceRatioSelector", i == 0 ? "Blue" : "Red", failure.out());
  if (failure) refuse(one, " cannot be selected: " + failure.text());
}

const char* feature_of(ArvCamera* camera, const Named& one) {
  if (is_pair(one) && !has_feature(camera, "BalanceRatioSelector")) return nullptr;
  for (const char* name : one.genicam) {
    if (name && has_feature(camera, name)) return name;
  }
  return nullptr;
}

bool is_integer(ArvCamera* camera, const char* feature) {
  ArvGcNode* const node = arv_device_get_feature(arv_camera_get_device(camera), feature);
  return ARV_IS_GC_INTEGER(node) && !ARV_IS_GC_FLOAT(node);
}

double value_of(ArvCamera* camera, const char* feature, GFailure& failure) {
  return is_integer(camera, feature)
             ? static_cast<double>(arv_camera_get_integer(camera, feature, failure.out()))
             : arv_camera_get_float(camera, feature, failure.out());
}

void get_limits(ArvCamera* camera, const char* feature, double& low, double& high,
                GFailure& failure) {
  if (!is_integer(camera, feature)) {
    return arv_camera_get_float_bounds(camera, feature, &low, &high, failure.out());
  }
  gint64 first = 0, last = 0;
  arv_camera_get_integer_bounds(camera, feature, &first, &last, failure.out());
  low = static_cast<double>(first);
  high = static_cast<double>(last);
}

bool is_automatic(ArvCamera* camera, const Named& one) {
  if (!one.automatic || !has_feature(camera, one.automatic)) return false;
  GFailure failure;
  const char* const mode = arv_camera_get_string(camera, one.automatic, failure.out());
  return !failure && mode && std::string(mode) != "Off";
}

std::optional<FeatureState> state_of(ArvCamera* camera, const Named& one) {
  const char* const feature = feature_of(camera, one);
  if (!feature) return std::nullopt;
  FeatureState state;
  state.name = one.name;
  state.unit = one.unit;
  state.is_automatic = is_automatic(camera, one);
  GFailure failure;
  for (std::size_t i = 0; i < (is_pair(one) ? 2u : 1u); ++i) {
    select(camera, one, i);
    const double value = value_of(camera, feature, failure);
    if (failure) return std::nullopt;
    state.values.push_back(value / one.scale);
  }
  get_limits(camera, feature, state.low, state.high, failure);
  state.low /= one.scale;
  state.high /= one.scale;
  return state;
}

void set_values(ArvCamera* camera, const Named& one, const FeatureWish& wish) {
  const char* const feature = feature_of(camera, one);
  const std::optional<FeatureState> state = state_of(camera, one);
  if (!feature || !state) refuse(one, ": this camera has no such feature");
  check_values(wish, *state);
  for (std::size_t i = 0; i < wish.values.size(); ++i) {
    select(camera, one, i);
    const double value = one.scale * wish.values[i];
    GFailure failure;
    if (is_integer(camera, feature)) {
      arv_camera_set_integer(camera, feature, std::llround(value), failure.out());
    } else {
      arv_camera_set_float(camera, feature, value, failure.out());
    }
    if (failure) refuse(one, " cannot be set: " + failure.text());
  }
}

void set_automatic(ArvCamera* camera, const Named& one, bool wanted) {
  if (!one.automatic || !has_feature(camera, one.automatic)) {
    if (wanted) refuse(one, ": this camera has no automatic one");
    return;
  }
  GFailure failure;
  arv_camera_set_string(camera, one.automatic, wanted ? "Continuous" : "Off", failure.out());
  if (failure) refuse(one, " cannot be set: " + failure.text());
}

}  // namespace

bool has_feature(ArvCamera* camera, const char* name) {
  GFailure failure;
  return arv_camera_is_feature_available(camera, name, failure.out()) && !failure;
}

void set_features(ArvCamera* camera, const std::vector<FeatureWish>& wishes) {
  for (const FeatureWish& wish : wishes) {
    const bool is_known = std::any_of(named.begin(), named.end(),
                                      [&](const Named& one) { return wish.name == one.name; });
    if (!is_known) {
      throw CaptureError(CaptureFault::failed,
                         "features." + wish.name + ": cameras on GigE have no such feature");
    }
  }
  for (const Named& one : named) {
    const auto wish = std::find_if(wishes.begin(), wishes.end(),
                                   [&](const FeatureWish& w) { return w.name == one.name; });
    const bool is_wished = wish != wishes.end();
    set_automatic(camera, one, is_wished && wish->is_automatic);
    if (is_wished && !wish->is_automatic) set_values(camera, one, *wish);
  }
}

std::vector<FeatureState> features_of(ArvCamera* camera) {
  std::vector<FeatureState> found;
  for (const Named& one : named) {
    if (const std::optional<FeatureState> state = state_of(camera, one)) found.push_back(*state);
  }
  return found;
}

}  // namespace robsim::gige
