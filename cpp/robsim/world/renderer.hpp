#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "robsim/world/scene.hpp"

namespace robsim {

/// Draws what the ceiling camera sees of a shared scene, without noise, on images of its own.
/// Restores only what the robot covered before, and never writes to an image that is still held
/// elsewhere.
class Renderer {
 public:
  explicit Renderer(std::shared_ptr<const Scene> scene) : scene_(std::move(scene)) {}

  /// A copy shares the scene, and draws on images of its own.
  Renderer(const Renderer& other) : scene_(other.scene_) {}
  Renderer& operator=(const Renderer& other) = delete;

  const std::shared_ptr<const Scene>& scene() const { return scene_; }
  int width() const { return scene_->width(); }
  int height() const { return scene_->height(); }
  const PlaneMap& camera() const { return scene_->camera(); }

  /// The map of the view panned by `pan`.
  PlaneMap plane_map(const Pan& pan) const { return scene_->plane_map(pan); }

  /// Without a pose the floor alone.
  Image render(const std::optional<Pose>& pose, const Pan& pan = {});

  /// What it draws on.
  struct Canvas {
    Image image;
    PixelBox dirty;  // what is to be restored: what the robot covers
    Pan pan;
  };

  /// The same on this canvas, of the size of the scene, whoever holds its image.
  Image render(const std::optional<Pose>& pose, const Pan& pan, Canvas& canvas) const;

 private:
  Canvas& free_canvas();

  std::shared_ptr<const Scene> scene_;
  std::vector<Canvas> canvases_;
};

}  // namespace robsim
