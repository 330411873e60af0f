#include "robsim/world/renderer.hpp"

#include <algorithm>

namespace robsim {

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
