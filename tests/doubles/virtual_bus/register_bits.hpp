#pragma once

#include <cstdint>
#include <cstring>

namespace robsim::virtual_bus {

constexpr std::uint32_t on = 1u << 31;  // bit 0 of IEEE 1394, which counts from the left

inline std::uint32_t bits_of_float(double value) {
  const auto narrow = static_cast<float>(value);
  std::uint32_t bits;
  std::memcpy(&bits, &narrow, sizeof bits);
  return bits;
}

inline double float_of_bits(std::uint32_t bits) {
  float value;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

}  // namespace robsim::virtual_bus
