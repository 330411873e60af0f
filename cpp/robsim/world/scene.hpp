#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "robsim/imaging/image.hpp"
#include "robsim/imaging/plane_map.hpp"
#include "robsim/world/robot_image.hpp"
#include "robsim/world/work_area.hpp"

namespace robsim {

/// One image twice: lit, and in the shadow.
struct Layer {
  Image lit;
  Image shadowed;
};

/// What lies under the robot: the work area itself (`home`), once, and around it the repeating
/// floor. The shadow stays with the view: it covers the columns from `shadow_left` on.
class Background {
 public:
  /// Throws std::invalid_argument unless all four images have the size of the camera's frame.
  Background(Layer floor, Layer home, int shadow_left, double shadow_factor);

  int width() const { return home_.lit.width(); }
  int height() const { return home_.lit.height(); }
  int shadow_left() const { return shadow_left_; }

  /// Brightness in the shadow relative to that in the light.
  double shadow_factor() const { return shadow_factor_; }

  /// Copies what the panned view shows in `box` to the same box of `view`.
  void copy(const PixelBox& box, const Pan& pan, const WritableView& view) const;

 private:
  Layer floor_;
  Layer home_;
  int shadow_left_;
  double shadow_factor_;
};

/// What the ceiling camera looks at: the floor, and the robot in any pose. It never changes, so
/// that any number of renderers can share it, in any thread.
class Scene {
 public:
  /// `camera` maps the pixels of the view before any pan to the work area.
  Scene(Background background, RobotImage robot, const PlaneMap& camera);

  int width() const { return background_.width(); }
  int height() const { return background_.height(); }
  const PlaneMap& camera() const { return camera_; }
  int headings() const { return robot_.headings(); }

  /// The map of the view panned by `pan`.
  PlaneMap plane_map(const Pan& pan) const;

  /// Draws the whole view, of the size of the scene. Without a pose the floor alone.
  void draw(const std::optional<Pose>& pose, const Pan& pan, const WritableView& view) const;

  /// Draws what the panned view shows of the floor in `box`.
  void draw_floor(const PixelBox& box, const Pan& pan, const WritableView& view) const;

  /// Draws the robot, and returns the box of the pixels changed.
  PixelBox draw_robot(const Pose& pose, const Pan& pan, const WritableView& view) const;

 private:
  Background background_;
  RobotImage robot_;
  PlaneMap camera_;
};

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
