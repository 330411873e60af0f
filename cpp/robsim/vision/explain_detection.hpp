#pragma once

#include <optional>
#include <string>

#include "robsim/imaging/plane_map.hpp"
#include "robsim/vision/locate.hpp"

namespace robsim {

/// The reason in a few words, such as "no red blob"; "detected" if there is none.
std::string name_of(DetectionResult result, const MarkerLayout& markers);
inline std::string name_of(const Detection& detection) {
  return name_of(detection.result, detection.markers);
}

/// A sentence for people, with the numbers that decided.
std::string explain(const Detection& detection);

/// What is to be said of markers of this width (frame px) that cannot be trusted at this noise
/// (grey levels); nothing of others.
std::optional<std::string> small_markers_remark(double width, double noise);

}  // namespace robsim
