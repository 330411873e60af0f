#pragma once

#include <optional>
#include <vector>

#include "robsim/imaging/plane_map.hpp"
#include "robsim/world/background.hpp"
#include "robsim/world/sprite/robot_image.hpp"

namespace robsim {

/// Draws what the ceiling camera sees, without noise. Restores only what the robot covered before,
/// and never writes to an image that is still held elsewhere.
class Renderer {
 public:
  /// `camera` maps the pixels of the view before any pan to the work area.
  Renderer(Background background, RobotImage robot, const PlaneMap& camera);

  int width() const { return background_.width(); }
  int height() const { return background_.height(); }
  const PlaneMap& camera() const { return camera_; }

  /// The map of the view panned by `pan`.
  PlaneMap plane_map(const Pan& pan) const;

  /// Without a pose the floor alone.
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
