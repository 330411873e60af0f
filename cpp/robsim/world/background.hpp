#pragma once

#include "robsim/imaging/image.hpp"
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

}  // namespace robsim
