#pragma once

#include <memory>

#include "robsim/imaging/resampling.hpp"
#include "robsim/world/scene.hpp"

namespace robsim {

/// The robot's flat top, at a height above the floor, as a camera elsewhere sees it.
class RaisedRobot {
 public:
  /// `warp` leads from the scene, seen from above, to the frame: that of the plane at the height.
  RaisedRobot(std::shared_ptr<const Scene> scene, std::shared_ptr<const Warp> warp);

  /// Draws it over a frame of the floor.
  void draw(const Pose& pose, const WritableView& frame);

 private:
  // The scene with nothing but the robot, before one colour.
  struct Cutout {
    Image image;
    std::uint8_t color;

    void fill(const PixelBox& box);
  };

  std::shared_ptr<const Scene> scene_;
  std::shared_ptr<const Warp> warp_;
  Cutout black_, white_;
};

}  // namespace robsim
