#include "robsim/lab/capture/gige/settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "robsim/lab/capture/capture_device.hpp"

namespace robsim {

namespace {

constexpr double slowest = 1e-3, fastest = 1e5;  // 1/s; a camera that tells another rate is wrong

[[noreturn]] void refuse(const std::string& text) {
  throw CaptureError(CaptureFault::failed, text);
}

std::string text_of(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%g", value);
  return text.data();
}

using Formats = std::vector<const PixelFormat*>;

// The camera's formats that robsim reads, the best one first.
Formats formats_of(ArvCamera* camera) {
  GFailure failure;
  guint count = 0;
  gint64* const codes = arv_camera_dup_available_pixel_formats(camera, &count, failure.out());
  Formats formats;
  for (const PixelFormat& format : pixel_formats()) {
    if (codes && std::count(codes, codes + count, format.genicam.code)) formats.push_back(&format);
  }
  g_free(codes);
  return formats;
}

std::string listed(const Formats& formats) {
  std::string text;
  for (const PixelFormat* format : formats) {
    text += (text.empty() ? "" : ", ") + std::string(format->genicam.name);
  }
  return text;
}

void apply_format(const std::string& wanted, ArvCamera* camera, const std::string& name) {
  const Formats possible = formats_of(camera);
  if (possible.empty()) {
    std::string names;
    for (const PixelFormat& one : pixel_formats()) {
      if (*one.genicam.name) names += std::string(" ") + one.genicam.name;
    }
    refuse(name + " has no pixel format that robsim reads:" + names);
  }
  const auto found = std::find_if(possible.begin(), possible.end(), [&](const PixelFormat* one) {
    return wanted.empty() || one->genicam.name == wanted || one->coding == wanted;
  });
  if (found == possible.end()) {
    refuse(name + ": its format must be one of " + listed(possible) + ", got " + wanted);
  }
  const auto [format, code] = (*found)->genicam;
  GFailure failure;
  arv_camera_set_pixel_format(camera, static_cast<ArvPixelFormat>(code), failure.out());
  if (failure) refuse(name + ": format " + format + " cannot be set: " + failure.text());
}

void apply_region(const GigeSettings& settings, ArvCamera* camera, const std::string& name) {
  if (!settings.region && !settings.size) return;
  GFailure failure;
  int width = 0, height = 0;
  arv_camera_get_sensor_size(camera, &width, &height, failure.out());
  if (failure) refuse(name + ": its region cannot be set: " + failure.text());
  SensorRegion wanted = settings.region.value_or(SensorRegion());
  if (!settings.region) {
    wanted = {(width - settings.size->first) / 2, (height - settings.size->second) / 2,
              settings.size->first, settings.size->second};
  }
  const bool is_inside = wanted.left >= 0 && wanted.top >= 0 &&
                         wanted.left + wanted.width <= width &&
                         wanted.top + wanted.height <= height;
  if (!is_inside) {
    refuse(name + ": region and size must lie in the sensor of " + size_text(width, height) +
           ", got " + size_text(wanted.width, wanted.height));
  }
  arv_camera_set_region(camera, wanted.left, wanted.top, wanted.width, wanted.height,
                        failure.out());
  if (failure) refuse(name + ": its region cannot be set: " + failure.text());
  SensorRegion got;
  arv_camera_get_region(camera, &got.left, &got.top, &got.width, &got.height, failure.out());
  if (failure || got.left != wanted.left || got.top != wanted.top || got.width != wanted.width ||
      got.height != wanted.height) {
    refuse(name + ": the camera makes the region (" + std::to_string(got.left) + ", " +
           std::to_string(got.top) + ", " + std::to_string(got.width) + ", " +
           std::to_string(got.height) + ") of it: give this one");
  }
}

double told_rate(ArvCamera* camera) {
  GFailure failure;
  double fps = 0;
  for (const char* resulting : {"ResultingFrameRate", "AcquisitionResultingFrameRate"}) {
    if (!gige::has_feature(camera, resulting)) continue;
    fps = arv_camera_get_float(camera, resulting, failure.out());
    if (!failure) return fps;
  }
  const char* const limit = "AcquisitionFrameRateEnable";
  const bool is_limited =
      !gige::has_feature(camera, limit) || arv_camera_get_boolean(camera, limit, failure.out());
  fps = arv_camera_get_frame_rate(camera, failure.out());
  return is_limited && !failure ? fps : 0;
}

void apply_rate(double fps, ArvCamera* camera, const std::string& name) {
  GFailure failure;
  arv_camera_set_frame_rate(camera, fps, failure.out());
  if (failure) refuse(name + ": fps cannot be set: " + failure.text());
  const double got = rate_of(camera);
  if (got > 0 && std::abs(got / fps - 1) > 0.01) {
    refuse(name + ": the camera makes " + text_of(got) + " of fps = " + text_of(fps) +
           ": give what it can, or a smaller region");
  }
}

}  // namespace

void apply(const GigeSettings& settings, ArvCamera* camera, const std::string& name) {
  // Cameras differ in what they have of this: one without a trigger needs none switched off.
  arv_camera_stop_acquisition(camera, GFailure().out());  // of a program that has crashed
  arv_camera_clear_triggers(camera, GFailure().out());
  arv_camera_set_acquisition_mode(camera, ARV_ACQUISITION_MODE_CONTINUOUS, GFailure().out());
  apply_format(settings.format, camera, name);
  apply_region(settings, camera, name);
  gige::set_features(camera, settings.features);
  if (settings.fps) apply_rate(*settings.fps, camera, name);
}

double rate_of(ArvCamera* camera) {
  const double fps = told_rate(camera);
  return fps >= slowest && fps <= fastest ? fps : 0;
}

}  // namespace robsim
