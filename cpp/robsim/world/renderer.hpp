#pragma once

#include <optional>
#include <vector>

#include "robsim/imaging/plane_map.hpp"
#include "robsim/world/background.hpp"
#include "robsim/world/sprite/robot_image.hpp"

namespace robsim {

/// Draws what the ceiling camera sees, without noise.
/// It restores only what the robot covered before, and never writes to an image that somebody
/// still holds.
class Renderer {
 public:
  /// `camera` maps the pixels of the view that has not been moved to the work area.
  Renderer(Background background, RobotImage robot, const PlaneMap& camera);

  int width() const { return background_.width(); }
  int height() const { return background_.height(); }
  const PlaneMap& camera() const { return camera_; }

  /// The map of a view moved by `pan`.
  PlaneMap plane_map(const Pan& pan) const;

  /// Without a pose the robot is hidden: the floor alone.
  Image render(const std::optional<Pose>& pose, const Pan& pan = {});

 private:
  struct Canvas {
    Image image;
    PixelBox dirty;  // what the robot covers
    Pan pan;
  };

  Canvas& free_canvas();

  Background background_;
  RobotImage robot_;
  PlaneMap camera_;
  std::vector<Canvas> canvases_;
};

}  // namespace robsim
