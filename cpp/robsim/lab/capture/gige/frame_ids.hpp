#pragma once

#include <cstdint>

namespace robsim {

/// How many frames of a GigE Vision camera are missing between two. Numbers of 16 bits go from
/// 65535 to 1, as 0 is none; longer ones of GigE Vision 2 go on.
inline std::int64_t lost_between(std::uint64_t last, std::uint64_t id) {
  constexpr std::int64_t cycle = 65535;
  const auto step = static_cast<std::int64_t>(id - last);
  if (last > cycle || id > cycle) return step > 0 ? step - 1 : 0;
  return step == 0 ? 0 : (step + cycle) % cycle - 1;
}

}  // namespace robsim
