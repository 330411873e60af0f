#include "robsim/lab/capture/firewire/fire_wire_camera.hpp"

#include <poll.h>
#include <sys/mman.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "robsim/base/system.hpp"
#include "robsim/imaging/raw/pixel_format.hpp"

namespace robsim::fire_wire {

namespace {

constexpr std::uint32_t n_buffers = 6;   // that the bus fills while one is read
constexpr int patience = 100;            // ms without a frame: then whoever asks may look around
constexpr double silence = 0.25;         // s, at least, before the camera is asked whether it sends
constexpr double silence_in_frames = 3;  // intervals
constexpr double silence_to_restart = 2;  // s
constexpr double oldest = 1;              // s; a time stamp that is older is none

// The library has room for as many packets as the camera says that a frame has, however few.
RawView view_of(const dc1394video_frame_t& frame) {
  try {
    const PixelFormat* const format = format_of(frame.color_coding, frame.color_filter);
    if (!format) throw std::invalid_argument("its coding is unknown");
    RawView raw = raw_view(frame.image, frame.total_bytes, *format, static_cast<int>(frame.size[0]),
                           static_cast<int>(frame.size[1]));
    raw.bits = std::clamp(static_cast<int>(frame.data_depth), 8, 16);
    return raw;
  } catch (const std::invalid_argument& error) {
    throw CaptureError(CaptureFault::failed,
                       std::string("the FireWire camera sends what is no frame: ") + error.what() +
                           ": ask for another coding or region");
  }
}

double wall_now() {
  timeval time{};
  gettimeofday(&time, nullptr);
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

// By how much the wall clock is ahead of the monotonic one, s: of three looks the shortest, since a
// thread may be held up between two clocks.
double wall_ahead() {
  double shortest = std::numeric_limits<double>::infinity(), ahead = 0;
  for (int i = 0; i < 3; ++i) {
    const double before = monotonic_now(), wall = wall_now(), after = monotonic_now();
    if (after - before >= shortest) continue;
    shortest = after - before;
    ahead = wall - (before + after) / 2;
  }
  return ahead;
}

bool lacks_room(dc1394error_t error) {
  return error == DC1394_NO_ISO_CHANNEL || error == DC1394_NO_BANDWIDTH;
}

}  // namespace

dc1394camera_t* FireWireCamera::camera() const {
  if (!handle_) throw CaptureError(CaptureFault::failed, "the FireWire camera is not open");
  return handle_->get();
}

void FireWireCamera::open() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (is_capturing_) return;
  try {
    start();
  } catch (const CaptureError& error) {
    const bool is_gone = error.fault() == CaptureFault::failed && !answers();
    stop_capture();
    handle_.reset();
    if (!is_gone) throw;
    throw CaptureError(CaptureFault::unplugged,
                       "the FireWire camera was unplugged while it was opened: plug it in again");
  }
  last_frame_ = monotonic_now();
  next_look_ = next_restart_ = 0;
  n_passed_ = 0;
}

bool FireWireCamera::answers() noexcept {
  try {
    if (!handle_) handle_ = std::make_unique<CameraHandle>(options_.choice);
    dc1394switch_t sends = DC1394_OFF;
    return dc1394_video_get_transmission(camera(), &sends) == DC1394_SUCCESS;
  } catch (const std::exception&) {
    return false;
  }
}

void FireWireCamera::start() {
  handle_ = std::make_unique<CameraHandle>(options_.choice);
  // What a program that crashed has left on would fill the bus.
  dc1394_video_set_transmission(camera(), DC1394_OFF);
  const std::vector<Video> videos = videos_for(camera(), options_.video);
  for (const Video& video : videos) {
    if (try_to_start(video)) return;
    // Less of the bus may do, unless a rate was asked for.
    if (options_.video.fps) break;
  }
  tell_of_no_room(videos.front());
}

// False if the bus has no room for it.
bool FireWireCamera::try_to_start(const Video& video) {
  const dc1394error_t error = set_up(video, DC1394_CAPTURE_FLAGS_DEFAULT);
  if (lacks_room(error)) return false;
  check(error, "start the capture");
  is_capturing_ = true;
  check(dc1394_video_set_transmission(camera(), DC1394_ON), "let the camera send");
  return true;
}

// After a failure the library must not be asked to stop: then the camera is given back, and taken
// anew.
dc1394error_t FireWireCamera::set_up(const Video& video, std::uint32_t flags) {
  if (!handle_) handle_ = std::make_unique<CameraHandle>(options_.choice);
  fire_wire::set_features(camera(), features_);
  video_ = video;
  video_->fps = apply(camera(), video);
  guid_ = handle_->guid();
  const dc1394error_t error = dc1394_capture_setup(camera(), n_buffers, flags);
  if (error != DC1394_SUCCESS) handle_.reset();
  return error;
}

// Linux says that there is no channel when there is no bandwidth: a channel alone tells.
void FireWireCamera::tell_of_no_room(const Video& video) {
  const bool has_channel = set_up(video, DC1394_CAPTURE_FLAGS_CHANNEL_ALLOC) == DC1394_SUCCESS;
  if (has_channel) {
    const int percent = static_cast<int>(100 * share_of_bus(camera()) + 0.5);
    dc1394_capture_stop(camera());
    throw CaptureError(
        CaptureFault::no_bandwidth,
        "the FireWire bus has no bandwidth left for " + text_of(video) + ", which takes " +
            std::to_string(percent) +
            " % of a bus: ask for less (fps, region, or coding='raw8'), or close the "
            "other camera");
  }
  throw CaptureError(CaptureFault::no_bandwidth,
                     "the FireWire bus has no isochronous channel left: close the other cameras, "
                     "or unplug and plug in one that a crashed program has left sending");
}

void FireWireCamera::stop_capture() noexcept {
  if (!handle_) return;
  if (is_capturing_) {
    dc1394_video_set_transmission(handle_->get(), DC1394_OFF);
    if (dc1394_capture_stop(handle_->get()) == DC1394_IOCTL_FAILURE) release_capture();
  }
  is_capturing_ = false;
  buffers_ = nullptr;
}

// Of a camera that is gone the library (2.2.7) stops nothing, and leaves open and mapped what it
// has.
void FireWireCamera::release_capture() noexcept {
  ::close(dc1394_capture_get_fileno(handle_->get()));
  if (buffers_) munmap(buffers_, buffer_bytes_);
}

void FireWireCamera::close() noexcept {
  const std::lock_guard<std::mutex> lock(mutex_);
  stop_capture();
  handle_.reset();
}

std::optional<Video> FireWireCamera::video() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return video_;
}

std::string FireWireCamera::guid() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return guid_;
}

std::vector<FeatureState> FireWireCamera::features() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return features_of(camera());
}

void FireWireCamera::set_features(const std::vector<FeatureWish>& wishes) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const std::vector<FeatureWish> all = overlaid(features_, wishes);
  fire_wire::set_features(camera(), all);
  features_ = all;
}

dc1394video_frame_t* FireWireCamera::dequeue() const {
  Frame* frame = nullptr;
  const dc1394error_t error = dc1394_capture_dequeue(camera(), DC1394_CAPTURE_POLICY_POLL, &frame);
  if (error == DC1394_SUCCESS) return frame;
  throw CaptureError(CaptureFault::unplugged, "the FireWire camera " + guid_ +
                                                  " has been unplugged, or its power has failed");
}

// The newest frame of those that have come, null if none has; the others are given back.
dc1394video_frame_t* FireWireCamera::newest() {
  Frame* frame = dequeue();
  if (!frame) return nullptr;
  std::uint32_t n_frames = 1;
  while (Frame* const newer = dequeue()) {
    dc1394_capture_enqueue(camera(), frame);
    frame = newer;
    ++n_frames;
    ++n_passed_;
  }
  if (n_frames < n_buffers) return frame;
  // All buffers were full: what came later is lost, and nobody knows how old this one is.
  dc1394_capture_enqueue(camera(), frame);
  ++n_passed_;
  return nullptr;
}

std::optional<Captured> FireWireCamera::next(ImagePool& pool) {
  pollfd ready{dc1394_capture_get_fileno(camera()), POLLIN, 0};
  const int n_ready = poll(&ready, 1, patience);
  const double now = monotonic_now();
  if (n_ready <= 0) {
    look_after_silence(now);
    return std::nullopt;
  }
  Frame* const frame = newest();
  if (!frame) return std::nullopt;
  buffers_ = frame->image - frame->id * frame->total_bytes;
  buffer_bytes_ = n_buffers * frame->total_bytes;
  Captured captured;
  captured.passed = std::exchange(n_passed_, 0);
  captured.arrived = now;
  captured.exposed = exposure_of(*frame);
  last_frame_ = now;
  const RawView raw = view_of(*frame);
  captured.image = pool.take(raw.width, raw.height);
  to_rgb(raw, captured.image.writable_view());
  dc1394_capture_enqueue(camera(), frame);
  return captured;
}

// The library gives the start of a frame by the wall clock, which may be set.
std::optional<double> FireWireCamera::exposure_of(const Frame& frame) const {
  if (frame.timestamp == 0) return std::nullopt;
  const double exposed = 1e-6 * static_cast<double>(frame.timestamp) - wall_ahead();
  const double age = monotonic_now() - exposed;
  if (age < 0 || age > oldest) return std::nullopt;
  return exposed;
}

// After a reset of the bus a camera may have forgotten that it was to send; one that does not even
// answer has been unplugged.
void FireWireCamera::look_after_silence(double now) {
  const double quiet = now - last_frame_;
  const double interval = video_ && video_->fps > 0 ? 1 / video_->fps : 0;
  if (quiet < std::max(silence, silence_in_frames * interval) || now < next_look_) return;
  next_look_ = now + silence;
  const std::lock_guard<std::mutex> lock(mutex_);
  dc1394switch_t sends = DC1394_OFF;
  if (dc1394_video_get_transmission(camera(), &sends) != DC1394_SUCCESS) {
    throw CaptureError(CaptureFault::unplugged, "the FireWire camera " + guid_ +
                                                    " does not answer any more: it has been "
                                                    "unplugged, or its power has failed");
  }
  if (sends == DC1394_OFF) {
    ++restarts_;
    check(dc1394_video_set_transmission(camera(), DC1394_ON), "let the camera send again");
  } else if (quiet > silence_to_restart && now >= next_restart_) {
    next_restart_ = now + silence_to_restart;
    ++restarts_;
    stop_capture();
    handle_.reset();
    start();
  }
}

}  // namespace robsim::fire_wire
