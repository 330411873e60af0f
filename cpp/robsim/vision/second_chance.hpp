#pragma once

#include <optional>
#include <vector>

#include "robsim/imaging/plane_map.hpp"
#include "robsim/vision/color/color_class.hpp"
#include "robsim/vision/locate.hpp"

namespace robsim {

/// A second chance for a detection without a pair: looks for its markers by colours relative to
/// brightness, as a saturation is, which neither dim light nor a gradient of light nor faded
/// markers hide; first relative to grey, then, under light that colours the floor, relative to the
/// floor. What is found takes the place of the detection; otherwise it stays as it is. Where the
/// first one found a pair, or so many blobs that one would be there by chance, there is no second
/// chance. `smoothing` (px), if not as markers and noise need it: in strong noise a window of up to
/// 0.4 of the marker's width, 9 px at most.
void look_again(Detection& detection, const ImageView& image, const std::vector<ColorClass>& colors,
                const PlaneMap& plane_map, std::optional<int> smoothing = std::nullopt);

}  // namespace robsim
