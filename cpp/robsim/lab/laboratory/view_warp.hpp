#pragma once

#include "robsim/imaging/resampling.hpp"
#include "robsim/world/scene.hpp"

namespace robsim {

/// From a scene, seen from above, to the frame of a camera elsewhere, by the map of its pixels.
Warp view_warp(const Scene& scene, int width, int height, const PlaneMap& plane_map);

}  // namespace robsim
