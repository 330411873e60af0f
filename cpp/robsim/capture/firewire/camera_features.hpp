#pragma once

#include <dc1394/dc1394.h>

#include <string>
#include <vector>

namespace robsim::fire_wire {

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
  std::string unit;            // "s", "dB"; "": as the camera counts
  double low = 0, high = 0;
};

/// Sets what is asked, and everything else to manual, with the value that it has. Throws
/// CaptureError that names the feature and its limits.
void set_features(dc1394camera_t* camera, const std::vector<FeatureWish>& wishes);

/// All that the camera has.
std::vector<FeatureState> features_of(dc1394camera_t* camera);

}  // namespace robsim::fire_wire
