#pragma once

#include <arv.h>

#include <optional>

#include "robsim/imaging/raw/pixel_format.hpp"

namespace robsim {

/// The format that has the bytes of a format of GigE Vision; nothing if none has.
inline std::optional<PixelFormat> pixel_format_of(ArvPixelFormat code) {
  switch (code) {
    case ARV_PIXEL_FORMAT_RGB_8_PACKED:
      return PixelFormat::rgb8;
    case ARV_PIXEL_FORMAT_BAYER_RG_8:
      return PixelFormat::bayer_rggb;
    case ARV_PIXEL_FORMAT_BAYER_GR_8:
      return PixelFormat::bayer_grbg;
    case ARV_PIXEL_FORMAT_BAYER_GB_8:
      return PixelFormat::bayer_gbrg;
    case ARV_PIXEL_FORMAT_BAYER_BG_8:
      return PixelFormat::bayer_bggr;
    case ARV_PIXEL_FORMAT_YUV_422_PACKED:
      return PixelFormat::yuv422;
    case ARV_PIXEL_FORMAT_MONO_8:
      return PixelFormat::mono8;
    default:
      return std::nullopt;
  }
}

}  // namespace robsim
