#pragma once

#include "robsim/imaging/image.hpp"

namespace robsim {

/// The image made smaller by whole factors, each pixel the mean of a block, until another factor
/// would make it narrower than `width`; what a factor leaves over at the right and below is
/// dropped. The same pixels where nothing is to be done.
Image reduced(const Image& image, int width);

}  // namespace robsim
