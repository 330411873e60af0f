#pragma once

#include <optional>

#include "robsim/imaging/plane_map.hpp"
#include "robsim/world/background.hpp"
#include "robsim/world/sprite/robot_image.hpp"

namespace robsim {

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

}  // namespace robsim
