#include "robsim/simulation/world/disturbance.hpp"

#include "robsim/base/elementary/elementary.hpp"

namespace robsim {

namespace {
constexpr std::uint64_t draws_per_step = 5;  // three for the pose, two for the motors

double draw(std::uint64_t seed, std::int64_t k, std::uint64_t i) {
  return random_normal(seed, draws_per_step * static_cast<std::uint64_t>(k) + i);
}
}  // namespace

Input Disturbance::disturbed(const Input& u, std::int64_t k) const {
  if (!is_on) return u;
  return {u.u1 + input_sigma[0] * draw(seed, k, 3), u.u2 + input_sigma[1] * draw(seed, k, 4)};
}

Pose Disturbance::disturbed(const Pose& pose, std::int64_t k) const {
  if (!is_on) return pose;
  const std::array<double, 3> n = {draw(seed, k, 0), draw(seed, k, 1), draw(seed, k, 2)};
  // w = L n, with L lower triangular
  const auto& L = pose_factor;
  return {pose.x + L(0, 0) * n[0], pose.y + (L(1, 0) * n[0] + L(1, 1) * n[1]),
          pose.heading + ((L(2, 0) * n[0] + L(2, 1) * n[1]) + L(2, 2) * n[2])};
}

}  // namespace robsim
