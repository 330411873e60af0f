#pragma once

#include <cstdint>
#include <optional>

#include "virtual_bus/bus_memory.hpp"

namespace robsim::virtual_bus {

constexpr std::uint64_t absolute_base = 0xF20000;  // of the registers of absolute values

/// Registers of brightness, exposure, white balance, shutter and gain: IIDC 1.31, 1.8 and 1.9.
/// `offset` counts from the control registers. Nothing, or false: it is no register of a feature.
std::optional<std::uint32_t> read_feature(const CameraState& camera, std::uint64_t offset);
bool write_feature(CameraState& camera, std::uint64_t offset, std::uint32_t value);

/// Registers of absolute values; `offset` counts from `absolute_base`.
std::optional<std::uint32_t> read_absolute(const CameraState& camera, std::uint64_t offset);
bool write_absolute(CameraState& camera, std::uint64_t offset, std::uint32_t value);

/// All features as after power-on: automatic.
void power_features_on(CameraState& camera);

/// How bright its settings make red, green and blue, as multiples of what the world is.
struct Brightness {
  double red = 1, green = 1, blue = 1;
};
Brightness brightness_of(const CameraState& camera);

}  // namespace robsim::virtual_bus
