#pragma once

#include <dc1394/dc1394.h>

#include <cstdint>
#include <optional>

namespace robsim::fire_wire {

/// The fastest speed between this computer and a camera: of its card, of the camera, and of what is
/// between them, as the kernel knows it. Nothing where it does not tell.
std::optional<dc1394speed_t> link_speed(std::uint64_t guid);

}  // namespace robsim::fire_wire
