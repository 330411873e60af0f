#pragma once

#include "robsim/vision/fit/edge_fit.hpp"

namespace robsim::fit {

/// Whether the light changes clearly from one side of a marker to the other: a quick look at what
/// the fit leaves. The fit must have been updated.
/// Method: score test (Rao, 1948) of a light that has a slope.
bool has_light_slope(const EdgeFit& marker);

}  // namespace robsim::fit
