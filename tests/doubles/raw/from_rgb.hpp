#pragma once

#include <cstdint>

#include "robsim/imaging/image.hpp"
#include "robsim/imaging/raw/pixel_format.hpp"

namespace robsim {

/// What a camera would send of an image: writes its `bytes_of`, rows without gaps. Chroma is the
/// mean of the pixels that share it, a Bayer pixel the channel that its filter passes, mono16 of
/// 16 bits. Throws std::invalid_argument as `check_size`.
void from_rgb(const ImageView& rgb, const PixelFormat& format, std::uint8_t* raw);

}  // namespace robsim
