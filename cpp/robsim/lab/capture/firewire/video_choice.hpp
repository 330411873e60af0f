#pragma once

#include <dc1394/dc1394.h>

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "robsim/imaging/raw/pixel_format.hpp"

namespace robsim::fire_wire {

/// What is asked of a camera.
struct VideoWish {
  std::optional<std::pair<int, int>> size;   // px
  std::optional<std::array<int, 4>> region;  // left, top, width, height on the sensor, px
  std::optional<double> fps;                 // 1/s
  std::string coding;                        // "yuv422"; "": the best one
};

/// A way to send frames that a camera has.
struct Video {
  dc1394video_mode_t mode{};
  const PixelFormat* format = nullptr;
  dc1394framerate_t rate{};                      // of the formats 0 to 2
  int left = 0, top = 0, width = 0, height = 0;  // px
  double fps = 0;                                // 1/s; of format 7 as far as the bus goes
  int packet_bytes = 0;
  dc1394speed_t speed{};

  bool has_region() const { return dc1394_is_video_mode_scalable(mode); }
};

/// "640 x 480 px yuv422 at 30 frames/s"
std::string text_of(const Video& video);

/// The format of a coding, for raw8 by the colour filter; null: unknown.
const PixelFormat* format_of(dc1394color_coding_t coding, int filter = DC1394_COLOR_FILTER_MIN);

/// What a camera has that fulfils a wish, the best one first: the rate up to 30 1/s, then the
/// colours. Throws CaptureError that lists what there is, if there is nothing.
std::vector<Video> videos_for(dc1394camera_t* camera, const VideoWish& wish);

/// Prepares a camera to send so. Returns the rate that it says it has (1/s). Throws CaptureError.
double apply(dc1394camera_t* camera, const Video& video);

/// Share of the bus that it takes, 0 to 1.
double share_of_bus(dc1394camera_t* camera);

}  // namespace robsim::fire_wire
