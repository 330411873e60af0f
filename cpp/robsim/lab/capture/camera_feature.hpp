#pragma once

#include <string>
#include <vector>

namespace robsim {

/// What is asked of a feature of a camera: to be automatic, or a value.
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

/// Earlier wishes, but for those of features that later ones are about, and the later ones.
std::vector<FeatureWish> overlaid(const std::vector<FeatureWish>& earlier,
                                  const std::vector<FeatureWish>& later);

/// Throws CaptureError that names the feature and its limits unless a camera can have the values
/// of a wish. `slack` is a part of the limits by which a value may pass them.
void check_values(const FeatureWish& wish, const FeatureState& state, double slack = 0);

}  // namespace robsim
