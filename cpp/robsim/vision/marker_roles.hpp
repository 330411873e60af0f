#pragma once

#include <array>
#include <optional>
#include <string>

#include "robsim/base/geometry.hpp"

namespace robsim {

/// What the two markers of a robot are called by where they sit on it: their roles.
enum class MarkerRoles { right_left, front_back };

inline constexpr std::array<MarkerRoles, 2> all_marker_roles = {MarkerRoles::right_left,
                                                                MarkerRoles::front_back};

/// The names of the first and of the second marker.
const std::array<std::string, 2>& names_of(MarkerRoles roles);

/// The roles of markers at two places, and whether the first place is that of right or front.
struct FittingRoles {
  MarkerRoles roles;
  bool is_first_right_or_front;
};

/// Of places in the robot's frame (x forward, y to its right): right and left if they lie beside
/// each other rather than one behind the other.
FittingRoles fitting_roles(const Point& one, const Point& other);

/// What contradicts these roles, such as "the right marker must lie ..."; nothing if they are true.
std::optional<std::string> contradiction(MarkerRoles roles, const Point& first,
                                         const Point& second);

}  // namespace robsim
