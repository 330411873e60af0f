#pragma once

#include <optional>

#include "robsim/vision/color/color_class.hpp"

namespace robsim::light {

/// A colour class relative to brightness: a colour belongs to it if its U - 128 and V - 128,
/// divided by the largest of R, G and B, lie within the limits. As with a saturation, light and
/// shadow do not change that.
struct RelativeClass {
  float lower[2];  // of U, V
  float upper[2];
  float darkest;  // level: what is darker is taken for so bright, as its colour drowns in noise
};

/// The class with limits as a colour class has them at full light, where a limit of 26 levels is a
/// saturation of 29 % (74 of 255); a class trained in dim light is taken for one of 26 levels. No
/// grey closer to neutral than `least_chroma` (levels) belongs to it. None for a class that limits
/// Y, or to which grey belongs.
std::optional<RelativeClass> relative_to_brightness(const ColorClass& color, float least_chroma);

}  // namespace robsim::light
