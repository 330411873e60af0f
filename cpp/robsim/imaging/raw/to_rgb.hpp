#pragma once

#include "robsim/imaging/image.hpp"
#include "robsim/imaging/raw/pixel_format.hpp"

namespace robsim {

/// The pixels of a camera as RGB8. YUV is that of IIDC and JPEG (ITU-R BT.601, all of 0 .. 255), to
/// within a level of its real numbers; the chroma of two or four pixels is that of each. Of a
/// Bayer filter the missing colours are the means of the two or four neighbours that have them,
/// mirrored at the edges. Grey has three equal channels.
/// Throws std::invalid_argument as `check_size`, and if the sizes or the strides do not fit.
void to_rgb(const RawView& raw, const WritableView& rgb);

}  // namespace robsim
