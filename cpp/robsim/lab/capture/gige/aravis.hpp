#pragma once

#include <arv.h>

#include <memory>
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

/// The format with the code of GenICam; null if none has it.
inline const PixelFormat* pixel_format_of(ArvPixelFormat code) {
  for (const PixelFormat& format : pixel_formats()) {
    if (format.genicam.code == code) return &format;
  }
  return nullptr;
}

}  // namespace robsim
