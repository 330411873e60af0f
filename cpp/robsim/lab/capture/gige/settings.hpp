#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "robsim/lab/capture/capture_device.hpp"
#include "robsim/lab/capture/gige/aravis.hpp"

namespace robsim::gige {

/// Sets what is asked, and switches off what else would change by itself. Throws CaptureError that
/// names the feature and its limits.
void set_features(ArvCamera* camera, const std::vector<FeatureWish>& wishes);

/// All that the camera has.
std::vector<FeatureState> features_of(ArvCamera* camera);

/// Whether it has a feature of GenICam.
bool has_feature(ArvCamera* camera, const char* name);

}  // namespace robsim::gige

namespace robsim {

/// A part of the sensor (px).
struct SensorRegion {
  int left = 0, top = 0, width = 0, height = 0;
};

struct GigeSettings {
  std::string format;                       // its name or its coding; empty: the best one
  std::optional<SensorRegion> region;       // none: as the camera has it
  std::optional<std::pair<int, int>> size;  // in its place: the middle of the sensor
  std::optional<double> fps;                // 1/s; none: as the camera has it
  std::vector<FeatureWish> features;
};

/// Lets a camera run freely with the settings, without automatic changes but for those asked for.
/// `name` begins what errors say. Throws CaptureError.
void apply(const GigeSettings& settings, ArvCamera* camera, const std::string& name);

/// Frames per second of a camera that runs freely; 0: it does not tell.
double rate_of(ArvCamera* camera);

}  // namespace robsim
