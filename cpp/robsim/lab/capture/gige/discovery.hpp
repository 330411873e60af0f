#pragma once

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

}  // namespace robsim
