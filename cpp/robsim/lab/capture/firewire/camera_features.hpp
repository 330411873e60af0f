#pragma once

#include <dc1394/dc1394.h>

#include <vector>

#include "robsim/lab/capture/camera_feature.hpp"

namespace robsim::fire_wire {

/// Sets what is asked, and everything else to manual, with the value that it has. Throws
/// CaptureError that names the feature and its limits.
void set_features(dc1394camera_t* camera, const std::vector<FeatureWish>& wishes);

/// All that the camera has.
std::vector<FeatureState> features_of(dc1394camera_t* camera);

}  // namespace robsim::fire_wire
