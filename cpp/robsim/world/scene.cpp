#include "robsim/world/scene.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "robsim/base/system.hpp"

namespace robsim {

namespace {

std::int64_t floor_divide(std::int64_t a, std::int64_t b) { return a / b - (a % b < 0 ? 1 : 0); }

}  // namespace

Background::Background(Layer floor, Layer home, int shadow_left, double shadow_factor)
    : floor_(std::move(floor)),
      home_(std::move(home)),
      shadow_left_(shadow_left),
      shadow_factor_(shadow_factor) {
  for (const Image* image : {&floor_.lit, &floor_.shadowed, &home_.shadowed}) {
    if (image->width() != width() || image->height() != height()) {
      throw std::invalid_argument("floor and home must be images of one size");
    }
  }
  checked(shadow_factor, shadow_factor >= 0 && shadow_factor <= 1,
          "shadow_factor must lie within 0..1");
}

void Background::copy(const PixelBox& box, const Pan& pan, const WritableView& view) const {
  for (int v = box.top; v < box.bottom; ++v) {
    const std::int64_t world_v = std::int64_t{v} + pan.v;
    const std::int64_t tile_v = floor_divide(world_v, height());
    const int source_v = static_cast<int>(world_v - tile_v * height());
    for (int u = box.left; u < box.right;) {
      const std::int64_t world_u = std::int64_t{u} + pan.u;
      const std::int64_t tile_u = floor_divide(world_u, width());
      const bool lit = u < shadow_left_;
      const std::int64_t tile_end = (tile_u + 1) * width() - pan.u;
      int end = static_cast<int>(std::min<std::int64_t>(box.right, tile_end));
      if (lit) end = std::min(end, shadow_left_);
      const Layer& layer = tile_u == 0 && tile_v == 0 ? home_ : floor_;
      const Image& source = lit ? layer.lit : layer.shadowed;
      const int source_u = static_cast<int>(world_u - tile_u * width());
      std::memcpy(view.row(v) + std::ptrdiff_t{3} * u,
                  source.row(source_v) + std::ptrdiff_t{3} * source_u,
                  std::size_t{3} * static_cast<std::size_t>(end - u));
      u = end;
    }
  }
}

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

namespace {
constexpr std::size_t maximum_canvases = 3;
}

Image Renderer::render(const std::optional<Pose>& pose, const Pan& pan) {
  return render(pose, pan, free_canvas());
}

Image Renderer::render(const std::optional<Pose>& pose, const Pan& pan, Canvas& canvas) const {
  const WritableView view = canvas.image.writable_view();
  if (!(canvas.pan == pan)) canvas.dirty = view.box();
  canvas.pan = pan;
  scene_->draw_floor(canvas.dirty, pan, view);
  canvas.dirty = view.box();  // if drawing fails
  canvas.dirty = pose ? scene_->draw_robot(*pose, pan, view) : PixelBox{};
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
