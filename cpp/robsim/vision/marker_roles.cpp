#include "robsim/vision/marker_roles.hpp"

#include <cmath>

#include "robsim/base/system.hpp"

namespace robsim {

namespace {

// Markers this near to 45 degrees count as beside each other: polygons in files are rounded.
constexpr double tie = 0.999;

// px; what is nearer is the same but for rounding
constexpr double apart = 1e-6;

}  // namespace

const std::array<std::string, 2>& names_of(MarkerRoles roles) {
  static const std::array<std::string, 2> right_left = {"right", "left"};
  static const std::array<std::string, 2> front_back = {"front", "back"};
  return roles == MarkerRoles::right_left ? right_left : front_back;
}

FittingRoles fitting_roles(const Point& one, const Point& other) {
  const double forward = one.x - other.x;
  const double right = one.y - other.y;
  if (std::fabs(right) >= tie * std::fabs(forward)) return {MarkerRoles::right_left, right > 0};
  return {MarkerRoles::front_back, forward > 0};
}

std::optional<std::string> contradiction(MarkerRoles roles, const Point& first,
                                         const Point& second) {
  const bool is_across = roles == MarkerRoles::right_left;
  const double one = is_across ? first.y : first.x;
  const double other = is_across ? second.y : second.x;
  if (one > other + apart) return std::nullopt;
  const auto& [first_name, second_name] = names_of(roles);
  return "the " + first_name + " marker must lie farther " +
         (is_across ? "to the right" : "ahead") + " than the " + second_name + " one, got " +
         to_text(one) + " px and " + to_text(other) + " px " +
         (is_across ? "to the right of" : "ahead of") + " the robot's centre";
}

}  // namespace robsim
