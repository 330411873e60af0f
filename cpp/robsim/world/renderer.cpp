#include "robsim/world/renderer.hpp"

#include <algorithm>
#include <utility>

namespace robsim {

namespace {
constexpr std::size_t maximum_canvases = 3;
}

Renderer::Renderer(Background background, RobotImage robot, const PlaneMap& camera)
    : background_(std::move(background)), robot_(std::move(robot)), camera_(camera) {}

PlaneMap Renderer::plane_map(const Pan& pan) const {
  const PlaneMap::Matrix& m = camera_.matrix();
  return PlaneMap(PlaneMap::Matrix{m[0], 0, m[2] + m[0] * pan.u,  //
                                   0, m[4], m[5] + m[4] * pan.v, 0, 0, 1});
}

Image Renderer::render(const std::optional<Pose>& pose, const Pan& pan) {
  Canvas& canvas = free_canvas();
  if (!(canvas.pan == pan)) canvas.dirty = canvas.image.box();
  canvas.pan = pan;
  background_.copy(canvas.dirty, pan, canvas.image);
  canvas.dirty = {};
  if (!pose) return canvas.image;
  const Point pixel = plane_map(pan).to_pixel({pose->x, pose->y});
  const Shadow shadow{background_.shadow_left(), background_.shadow_factor()};
  canvas.dirty = robot_.draw(pixel, pose->heading, shadow, canvas.image);
  return canvas.image;
}

Renderer::Canvas& Renderer::free_canvas() {
  const auto free = std::find_if(canvases_.begin(), canvases_.end(),
                                 [](const Canvas& c) { return !c.image.is_shared(); });
  if (free != canvases_.end()) return *free;
  if (canvases_.size() == maximum_canvases) canvases_.erase(canvases_.begin());
  Image image(width(), height());
  canvases_.push_back({image, image.box(), {}});
  return canvases_.back();
}

}  // namespace robsim
