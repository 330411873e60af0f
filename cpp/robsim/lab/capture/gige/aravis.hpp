#pragma once

#include <arv.h>

#include <memory>
#include <optional>
#include <string>

#include "robsim/imaging/raw/pixel_format.hpp"

namespace robsim {

struct Unreferenced {
  void operator()(gpointer object) const { g_object_unref(object); }
};

/// A reference to an object of GLib.
template <typename T>
using GReference = std::unique_ptr<T, Unreferenced>;

/// Where a function of Aravis tells its error.
class GFailure {
 public:
  GFailure() = default;
  ~GFailure() { g_clear_error(&error_); }
  GFailure(const GFailure&) = delete;
  GFailure& operator=(const GFailure&) = delete;

  GError** out() {
    g_clear_error(&error_);
    return &error_;
  }
  explicit operator bool() const { return error_ != nullptr; }
  bool is(ArvDeviceError code) const {
    return error_ && error_->domain == ARV_DEVICE_ERROR && error_->code == static_cast<int>(code);
  }
  std::string text() const { return error_ ? error_->message : "unknown"; }

 private:
  GError* error_ = nullptr;
};

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
