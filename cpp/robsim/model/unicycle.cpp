#include "robsim/model/unicycle.hpp"

#include "robsim/base/elementary/sine.hpp"

namespace robsim {

Pose Unicycle::operator()(const RobotModel& model, const Pose& pose_1, const Pose& pose_2,
                          const Input& u) const {
  const auto x = model.theta().row(0);
  // s(k-1) = (x(k-1) - x(k-2)) cos heading(k-2) + (y(k-1) - y(k-2)) sin heading(k-2)
  const elementary::SinCos before = elementary::sin_cos(pose_2.heading);
  const double step_before =
      (pose_1.x - pose_2.x) * before.cos + (pose_1.y - pose_2.y) * before.sin;
  // s(k) = -a2X s(k-1) + b1X u1(k-1) + b2X u2(k-1) + d1X
  const double step = -x[1] * step_before + x[2] * u.u1 + x[3] * u.u2 + x[4];
  // x(k) = x(k-1) + s(k) cos heading(k-1),  y(k) = y(k-1) + s(k) sin heading(k-1)
  const elementary::SinCos now = elementary::sin_cos(pose_1.heading);
  return {pose_1.x + step * now.cos, pose_1.y + step * now.sin,
          model.predict(pose_1, pose_2, u).heading};
}

}  // namespace robsim
