#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "virtual_bus/bus_memory.hpp"

namespace robsim::virtual_bus {

/// What a camera sends, by its registers.
struct Transmission {
  bool is_on = false;
  int channel = 0;
  std::uint32_t speed = 0;  // 2: S400
  Coding coding = Coding::mono8;
  int left = 0, top = 0, width = 0, height = 0;  // px
  int packet_bytes = 0;
  int n_packets = 0;  // of a frame
  int every = 1;      // only each n-th picture of the sensor is sent
};

/// Registers of a camera by their addresses, counted from the start of the configuration ROM less
/// 0x400: IIDC 1394-based Digital Camera Specification 1.31. Nothing: there is no such register.
/// Called under the lock of the bus.
std::optional<std::uint32_t> read_register(CameraState& camera, std::uint64_t address);
bool write_register(CameraState& camera, std::uint64_t address, std::uint32_t value);

Transmission transmission_of(CameraState& camera);

/// All values as after power-on.
void power_on(CameraState& camera);

/// Nobody is sent frames any more, as when the power has failed for a moment.
void stop_transmission(CameraState& camera);

std::vector<std::uint32_t> config_rom_of(const CameraState& camera);

/// That of the bus's own node, which is no camera.
std::vector<std::uint32_t> config_rom_of_computer();

}  // namespace robsim::virtual_bus
