#pragma once

#include <dc1394/dc1394.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "robsim/lab/capture/capture_device.hpp"
#include "robsim/lab/capture/firewire/fire_wire_bus.hpp"
#include "robsim/lab/capture/firewire/video_choice.hpp"

namespace robsim::fire_wire {

/// Sets what is asked, and everything else to manual, with the value that it has. Throws
/// CaptureError that names the feature and its limits.
void set_features(dc1394camera_t* camera, const std::vector<FeatureWish>& wishes);

/// All that the camera has.
std::vector<FeatureState> features_of(dc1394camera_t* camera);

struct CameraOptions {
  std::string choice;  // as CameraHandle takes it
  VideoWish video;
  std::vector<FeatureWish> features;
};

/// A camera on FireWire, read by libdc1394. `open`, `next` and `close` are for the thread of a
/// grabber; the others for any.
class FireWireCamera : public CaptureDevice {
 public:
  explicit FireWireCamera(CameraOptions options)
      : options_(std::move(options)), features_(options_.features) {}
  ~FireWireCamera() override { close(); }

  void open() override;
  std::optional<Captured> next(ImagePool& pool) override;
  void close() noexcept override;

  /// What it sends; nothing before it is open.
  std::optional<Video> video() const;
  std::string guid() const;

  /// How its features are set. What is set holds when it is opened again, too. Throws CaptureError,
  /// also if it is not open.
  std::vector<FeatureState> features() const;
  void set_features(const std::vector<FeatureWish>& wishes);

  /// Times that it was told to send again, since it had forgotten, and that its capture was set up
  /// anew.
  int restarts() const { return restarts_; }

 private:
  using Frame = dc1394video_frame_t;

  dc1394camera_t* camera() const;
  bool answers() noexcept;
  void start();
  bool try_to_start(const Video& video);
  dc1394error_t set_up(const Video& video, std::uint32_t flags);
  [[noreturn]] void tell_of_no_room(const Video& video);
  void stop_capture() noexcept;
  void release_capture() noexcept;

  Frame* dequeue() const;
  Frame* newest();
  std::optional<double> exposure_of(const Frame& frame) const;
  void look_after_silence(double now);

  const CameraOptions options_;
  mutable std::mutex mutex_;  // of the registers
  std::unique_ptr<CameraHandle> handle_;
  std::vector<FeatureWish> features_;  // all that were asked for
  std::optional<Video> video_;
  std::string guid_;
  bool is_capturing_ = false;
  void* buffers_ = nullptr;  // of the library, once a frame of theirs has come
  std::size_t buffer_bytes_ = 0;
  double last_frame_ = 0, next_look_ = 0, next_restart_ = 0;  // monotonic, s
  std::int64_t n_passed_ = 0;  // frames since the last one that was read
  std::atomic<int> restarts_{0};
};

}  // namespace robsim::fire_wire
