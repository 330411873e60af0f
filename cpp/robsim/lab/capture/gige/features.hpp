#pragma once

#include <vector>

#include "robsim/lab/capture/camera_feature.hpp"
#include "robsim/lab/capture/gige/handles.hpp"

namespace robsim::gige {

/// Sets what is asked, and switches off what else would change by itself. Throws CaptureError that
/// names the feature and its limits.
void set_features(ArvCamera* camera, const std::vector<FeatureWish>& wishes);

/// All that the camera has.
std::vector<FeatureState> features_of(ArvCamera* camera);

/// Whether it has a feature of GenICam.
bool has_feature(ArvCamera* camera, const char* name);

}  // namespace robsim::gige
