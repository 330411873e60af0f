#pragma once

#include <string>
#include <vector>

#include "robsim/capture/gige/handles.hpp"

namespace robsim::gige {

/// What is asked of a feature: to be automatic, or a value.
struct FeatureWish {
  std::string name;  // "shutter"
  bool is_automatic = false;
  std::vector<double> values;  // one; of the white balance two: blue, red
};

/// How a feature is set.
struct FeatureState {
  std::string name;
  bool is_automatic = false;
  std::vector<double> values;  // one; of the white balance two: blue, red
  std::string unit;            // "s"; "": as the camera counts
  double low = 0, high = 0;
};

/// Sets what is asked, and switches off what else would change by itself. Throws CaptureError that
/// names the feature and its limits.
void set_features(ArvCamera* camera, const std::vector<FeatureWish>& wishes);

/// All that the camera has.
std::vector<FeatureState> features_of(ArvCamera* camera);

/// Whether it has a feature of GenICam.
bool has_feature(ArvCamera* camera, const char* name);

}  // namespace robsim::gige
