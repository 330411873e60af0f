#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace robsim {

/// What a GigE Vision camera says of itself.
struct GigeIdentity {
  std::string address;
  std::string interface_address;  // of ours, that leads to it
  std::string vendor, model, serial, user_name;
};

constexpr int gvcp_port = 3956;

/// Asks the camera at an IPv4 address or host name; nothing if none answers within `patience` s.
std::optional<GigeIdentity> ask_gige_camera(const std::string& host, double patience);

/// All cameras that answer on the networks of this computer within some seconds.
std::vector<GigeIdentity> find_gige_cameras(double seconds);

bool is_ipv4_address(const std::string& text);

/// How many frames of a GigE Vision camera are missing between two. Numbers of 16 bits go from
/// 65535 to 1, as 0 is none; longer ones of GigE Vision 2 go on.
inline std::int64_t lost_between(std::uint64_t last, std::uint64_t id) {
  constexpr std::int64_t cycle = 65535;
  const auto step = static_cast<std::int64_t>(id - last);
  if (last > cycle || id > cycle) return step > 0 ? step - 1 : 0;
  return step == 0 ? 0 : (step + cycle) % cycle - 1;
}

}  // namespace robsim
