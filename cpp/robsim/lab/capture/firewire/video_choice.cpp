#include "robsim/lab/capture/firewire/video_choice.hpp"

#include <dc1394/register.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <tuple>

#include "robsim/lab/capture/firewire/fire_wire_bus.hpp"

namespace robsim::fire_wire {

namespace {

constexpr double wanted_rate = 30;        // 1/s; more is of no use for such a robot
constexpr double cycles = 8000;           // 1/s, of the bus
constexpr double bandwidth_units = 4915;  // of the bus
constexpr double same_rate = 0.02;        // relative

double rate_of(dc1394framerate_t rate) {
  float value = 0;
  return dc1394_framerate_as_float(rate, &value) == DC1394_SUCCESS ? double{value} : 0.0;
}

// The fastest speed that a camera and the way to it have.
dc1394speed_t fastest_speed(const dc1394camera_t* camera) {
  const dc1394speed_t own = camera->bmode_capable ? DC1394_ISO_SPEED_800 : DC1394_ISO_SPEED_400;
  return std::min(own, link_speed(camera->guid).value_or(own));
}

int most_packet_bytes(dc1394speed_t speed) { return 1024 << (speed - DC1394_ISO_SPEED_100); }

// S400, or the fastest one where packets need it; nothing if they are too large for that.
std::optional<dc1394speed_t> speed_for(double packet_bytes, dc1394speed_t fastest) {
  for (const dc1394speed_t speed : {std::min(fastest, DC1394_ISO_SPEED_400), fastest}) {
    if (packet_bytes <= most_packet_bytes(speed)) return speed;
  }
  return {};
}

// Packets of a frame of the formats 0 to 2, whole fractions of its lines each: IIDC 1.31, 2.1.
double packets_of(const Video& video) { return (video.height == 768 ? 256 : 240) * 30 / video.fps; }

void set_speed(dc1394camera_t* camera, dc1394speed_t speed) {
  if (camera->bmode_capable) {
    const bool is_fast = speed > DC1394_ISO_SPEED_400;
    check(dc1394_video_set_operation_mode(
              camera, is_fast ? DC1394_OPERATION_MODE_1394B : DC1394_OPERATION_MODE_LEGACY),
          "set the mode of 1394b");
  }
  check(dc1394_video_set_iso_speed(camera, speed), "set the speed of the bus");
}

// Modes of the formats 0 to 2.
void add_fixed(dc1394camera_t* camera, dc1394video_mode_t mode, dc1394speed_t fastest,
               std::vector<Video>& found) {
  std::uint32_t width = 0, height = 0;
  dc1394color_coding_t coding{};
  dc1394framerates_t rates{};
  if (dc1394_get_image_size_from_video_mode(camera, mode, &width, &height) != DC1394_SUCCESS ||
      dc1394_get_color_coding_from_video_mode(camera, mode, &coding) != DC1394_SUCCESS ||
      dc1394_video_get_supported_framerates(camera, mode, &rates) != DC1394_SUCCESS) {
    return;
  }
  Video video;
  video.mode = mode;
  video.format = format_of(coding);
  if (!video.format) return;
  video.width = static_cast<int>(width);
  video.height = static_cast<int>(height);
  for (std::uint32_t i = 0; i < rates.num; ++i) {
    video.rate = rates.framerates[i];
    video.fps = rate_of(video.rate);
    if (video.fps <= 0) continue;
    const double bytes = video.width * video.height * video.format->bits / 8.0;
    const auto speed = speed_for(bytes / packets_of(video), fastest);
    if (!speed) continue;
    video.speed = *speed;
    found.push_back(video);
  }
}

// Left, top, width, height that format 7 is asked for: all of the sensor, unless a region is.
std::optional<std::array<int, 4>> region_for(dc1394camera_t* camera, dc1394video_mode_t mode,
                                             const VideoWish& wish) {
  std::uint32_t width = 0, height = 0, across = 1, down = 1, right = 0, below = 0;
  if (dc1394_format7_get_max_image_size(camera, mode, &width, &height) != DC1394_SUCCESS) return {};
  const auto all_width = static_cast<int>(width), all_height = static_cast<int>(height);
  if (!wish.region) return std::array<int, 4>{0, 0, all_width, all_height};
  dc1394_format7_get_unit_size(camera, mode, &across, &down);
  if (dc1394_format7_get_unit_position(camera, mode, &right, &below) != DC1394_SUCCESS) {
    right = below = 0;
  }
  if (!right) right = across;
  if (!below) below = down;
  const auto [l, t, w, h] = *wish.region;
  const auto is_multiple = [](int value, std::uint32_t unit) {
    return unit == 0 || value % static_cast<int>(unit) == 0;
  };
  if (l + w > all_width || t + h > all_height || !is_multiple(w, across) || !is_multiple(h, down) ||
      !is_multiple(l, right) || !is_multiple(t, below)) {
    char text[256];
    std::snprintf(text, sizeof text,
                  "region must lie on the sensor of %d x %d px, its size in steps of %u x %u px, "
                  "its left top corner in steps of %u x %u px, got (%d, %d, %d, %d)",
                  all_width, all_height, across, down, right, below, l, t, w, h);
    throw CaptureError(CaptureFault::failed, text);
  }
  return wish.region;
}

// Format 7: any region, and any rate that the packets allow.
void add_scalable(dc1394camera_t* camera, dc1394video_mode_t mode, const VideoWish& wish,
                  dc1394speed_t fastest, std::vector<Video>& found) {
  const auto region = region_for(camera, mode, wish);
  dc1394color_codings_t offered{};
  if (!region || dc1394_format7_get_color_codings(camera, mode, &offered) != DC1394_SUCCESS) return;
  for (std::uint32_t i = 0; i < offered.num; ++i) {
    Video video;
    video.mode = mode;
    video.format = format_of(offered.codings[i]);
    if (!video.format) continue;
    video.left = (*region)[0];
    video.top = (*region)[1];
    video.width = (*region)[2];
    video.height = (*region)[3];
    if (video.width < 1 || video.height < 1) continue;
    const std::int64_t bytes = std::int64_t{video.width} * video.height * video.format->bits / 8;
    for (const double rate : {wish.fps.value_or(wanted_rate), 15.0, 7.5, 3.75, 1.875}) {
      if (wish.fps && rate != *wish.fps) break;
      // A frame goes in whole packets, one a cycle, in steps of four bytes.
      const std::int64_t n_packets = std::max(1, static_cast<int>(cycles / rate));
      const std::int64_t packet = (bytes + 4 * n_packets - 1) / (4 * n_packets) * 4;
      const auto speed = speed_for(static_cast<double>(packet), fastest);
      if (!speed) continue;
      video.speed = *speed;
      video.packet_bytes = static_cast<int>(packet);
      video.fps = rate;
      found.push_back(video);
    }
  }
}

// The library divides by the step of packets.
void check_packets(dc1394camera_t* camera, dc1394video_mode_t mode) {
  std::uint32_t step = 0, most = 0;
  check(dc1394_format7_get_packet_parameters(camera, mode, &step, &most),
        "ask the camera for its packets");
  if (step == 0 || most == 0) {
    throw CaptureError(CaptureFault::failed,
                       "the camera says that the packets of this mode have no bytes: ask for "
                       "another size or coding");
  }
}

// Seconds from frame to frame, as newer cameras tell; 0: unknown. libdc1394 itself takes the bits
// of the number for an integer.
double interval_of(dc1394camera_t* camera, dc1394video_mode_t mode) {
  constexpr std::uint64_t frame_interval_inquiry = 0x50;  // IIDC 1.31, 4.9.3
  std::uint32_t bits = 0;
  float seconds = 0;
  if (dc1394_get_format7_register(camera, mode, frame_interval_inquiry, &bits) != DC1394_SUCCESS) {
    return 0;
  }
  std::memcpy(&seconds, &bits, sizeof seconds);
  return seconds > 1e-4F && seconds < 100 ? double{seconds} : 0.0;
}

std::vector<Video> all_videos(dc1394camera_t* camera, const VideoWish& wish) {
  dc1394video_modes_t modes{};
  check(dc1394_video_get_supported_modes(camera, &modes), "ask the camera for its modes");
  const dc1394speed_t fastest = fastest_speed(camera);
  std::vector<Video> found;
  for (std::uint32_t i = 0; i < modes.num; ++i) {
    if (dc1394_is_video_mode_scalable(modes.modes[i])) {
      add_scalable(camera, modes.modes[i], wish, fastest, found);
    } else if (!wish.region && !dc1394_is_video_mode_still_image(modes.modes[i])) {
      add_fixed(camera, modes.modes[i], fastest, found);
    }
  }
  return found;
}

bool fits(const Video& video, const VideoWish& wish) {
  if (wish.size && *wish.size != std::pair(video.width, video.height)) return false;
  if (!wish.coding.empty() && video.format->coding != wish.coding) return false;
  return !wish.fps || std::abs(video.fps - *wish.fps) <= same_rate * *wish.fps;
}

// The larger, the better: the rate, the size, the colours, a fixed mode.
auto worth_of(const Video& video) {
  return std::tuple(std::min(video.fps, wanted_rate), std::int64_t{video.width} * video.height,
                    video.format->iidc.worth, !video.has_region(), -video.fps);
}

std::string what_of(const Video& video) {
  return size_text(video.width, video.height) + " " + video.format->coding;
}

std::string list_of(const std::vector<Video>& videos) {
  std::map<std::string, std::set<double, std::greater<>>> rates;
  for (const Video& video : videos) rates[what_of(video)].insert(video.fps);
  std::string text;
  for (const auto& [what, all] : rates) {
    text += (text.empty() ? "" : "; ") + what + " at ";
    for (const double fps : all) {
      char rate[32];
      std::snprintf(rate, sizeof rate, "%s%g", fps == *all.begin() ? "" : ", ", fps);
      text += rate;
    }
    text += " frames/s";
  }
  return text.empty() ? "nothing that is read here" : text;
}

}  // namespace

const PixelFormat* format_of(dc1394color_coding_t coding, int filter) {
  const PixelFormat* found = nullptr;
  for (const PixelFormat& one : pixel_formats()) {
    if (one.iidc.coding != coding - DC1394_COLOR_CODING_MIN) continue;
    if (!found || one.iidc.filter == filter - DC1394_COLOR_FILTER_MIN) found = &one;
  }
  return found;
}

std::string text_of(const Video& video) {
  char text[96];
  std::snprintf(text, sizeof text, "%d x %d px %s at %g frames/s", video.width, video.height,
                video.format->coding, video.fps);
  return text;
}

std::vector<Video> videos_for(dc1394camera_t* camera, const VideoWish& wish) {
  const std::vector<Video> all = all_videos(camera, wish);
  std::vector<Video> found;
  for (const Video& video : all) {
    if (fits(video, wish)) found.push_back(video);
  }
  if (found.empty()) {
    VideoWish at_any_rate = wish;
    at_any_rate.fps.reset();
    throw CaptureError(CaptureFault::failed, "the camera cannot send what was asked for; it has " +
                                                 list_of(all_videos(camera, at_any_rate)));
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Video& a, const Video& b) { return worth_of(a) > worth_of(b); });
  return found;
}

double apply(dc1394camera_t* camera, const Video& video) {
  set_speed(camera, video.speed);
  check(dc1394_video_set_mode(camera, video.mode), "set the video mode");
  if (!video.has_region()) {
    check(dc1394_video_set_framerate(camera, video.rate), "set the frame rate");
    return video.fps;
  }
  check_packets(camera, video.mode);
  const auto coding =
      static_cast<dc1394color_coding_t>(DC1394_COLOR_CODING_MIN + video.format->iidc.coding);
  check(dc1394_format7_set_roi(camera, video.mode, coding, video.packet_bytes, video.left,
                               video.top, video.width, video.height),
        "set the region");
  const double interval = interval_of(camera, video.mode);
  return interval > 0 ? 1 / interval : video.fps;
}

double share_of_bus(dc1394camera_t* camera) {
  std::uint32_t units = 0;
  return dc1394_video_get_bandwidth_usage(camera, &units) == DC1394_SUCCESS
             ? units / bandwidth_units
             : 0.0;
}

}  // namespace robsim::fire_wire
