#pragma once

#include <array>
#include <optional>

#include "robsim/vision/fit/edge_fit.hpp"

namespace robsim::fit {

/// Whether the light changes clearly from one side of a marker to the other: a quick look at what
/// the fit leaves. The fit must have been updated.
/// Method: score test (Rao, 1948) of a light that has a slope.
bool has_light_slope(const EdgeFit& marker);

/// A line in the picture across which the light changes, as at the edge of a shadow: the pixels
/// with normal . (u, v) > offset lie beyond it (frame px).
struct LightStep {
  double normal_u = 1;
  double normal_v = 0;
  double offset = 0;
};

/// The line that divides the pixels of a marker into two sides that fit much better with levels
/// and contrasts of their own. Nothing where no line does, by more than chance. The fit must have
/// been updated.
/// Method: a split of a regression tree (Breiman et al., 1984) along oblique lines.
std::optional<LightStep> find_light_step(const EdgeFit& marker);

/// The pixels on each side of a line; those that it may go through are left out.
std::array<EdgePixels, 2> divided(const EdgePixels& pixels, const LightStep& step);

}  // namespace robsim::fit
