#pragma once

#include "robsim/imaging/lens.hpp"
#include "robsim/imaging/warp.hpp"
#include "robsim/world/scene.hpp"

namespace robsim {

/// From a scene, seen from above, to the frame of a camera elsewhere: `plane_map` is that of its
/// ideal pixels, which the lens moves.
Warp view_warp(const Scene& scene, int width, int height, const PlaneMap& plane_map,
               const Lens& lens);

}  // namespace robsim
