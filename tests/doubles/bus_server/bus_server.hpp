#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "robsim/lab/capture/capture_device.hpp"

namespace robsim {

/// A camera on the virtual FireWire bus.
struct BusCameraOptions {
  int width = 0, height = 0;  // px
  double fps = 30;            // 1/s
  std::vector<std::string>
      codings;  // "mono8", "yuv411", "yuv422", "yuv444", "rgb8", "mono16", "raw8"
  std::string color_filter = "rggb";  // of raw8
  bool is_fast = false;               // S800, not S400
};

/// Makes a virtual FireWire bus, and keeps the pictures of its cameras up to date, from a thread
/// for each. Other processes, and this one, see it through the preloaded library. Linux only. Its
/// methods are for any thread; cameras are counted from 0.
class BusServer {
 public:
  /// `path` is the file of the bus, which must not be there yet. A camera shows what its device
  /// delivers; while that is unplugged, so is the camera. The computer's card has S800, or only
  /// S400. Throws std::invalid_argument, and std::runtime_error if it cannot be made.
  BusServer(const std::string& path, const std::vector<BusCameraOptions>& cameras,
            std::vector<std::shared_ptr<CaptureDevice>> devices, bool card_is_fast);
  ~BusServer();
  BusServer(const BusServer&) = delete;
  BusServer& operator=(const BusServer&) = delete;

  /// Ends it: cameras are unplugged, and the file is gone.
  void close() noexcept;

  std::string guid_of(int camera) const;
  void unplug(int camera);
  void plug_in(int camera);
  void stall(double seconds, int camera);
  void deny(int camera, bool is_denied);
  void shorten(int camera, bool is_short);
  void simplify(int camera);

  /// Resets the bus. Where the power fails for a moment, cameras forget that they were to send.
  void reset(bool power_fails);

  void refuse(bool channels, bool bandwidth);

  /// Number of a camera's frames for which a reader had no buffer left.
  std::int64_t lost_frames(int camera) const;

  /// Whether a camera is to send frames.
  bool is_sending(int camera) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace robsim
