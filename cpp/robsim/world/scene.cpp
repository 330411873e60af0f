#include "robsim/world/scene.hpp"

#include <utility>

namespace robsim {

Scene::Scene(Background background, RobotImage robot, const PlaneMap& camera)
    : background_(std::move(background)), robot_(std::move(robot)), camera_(camera) {}

PlaneMap Scene::plane_map(const Pan& pan) const {
  const PlaneMap::Matrix& m = camera_.matrix();
  return PlaneMap(PlaneMap::Matrix{m[0], 0, m[2] + m[0] * pan.u,  //
                                   0, m[4], m[5] + m[4] * pan.v, 0, 0, 1});
}

void Scene::draw(const std::optional<Pose>& pose, const Pan& pan, const WritableView& view) const {
  draw_floor(view.box(), pan, view);
  if (pose) draw_robot(*pose, pan, view);
}

void Scene::draw_floor(const PixelBox& box, const Pan& pan, const WritableView& view) const {
  background_.copy(box, pan, view);
}

PixelBox Scene::draw_robot(const Pose& pose, const Pan& pan, const WritableView& view) const {
  const Point pixel = plane_map(pan).to_pixel({pose.x, pose.y});
  const Shadow shadow{background_.shadow_left(), background_.shadow_factor()};
  return robot_.draw(pixel, pose.heading, shadow, view);
}

}  // namespace robsim
