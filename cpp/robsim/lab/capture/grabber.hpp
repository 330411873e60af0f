#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "robsim/imaging/plane_map.hpp"
#include "robsim/lab/capture/capture_device.hpp"

namespace robsim {

struct GrabberOptions {
  int every = 1;                            // only each n-th frame is handed over
  double frame_timeout = 1;                 // s without a frame, after which it is a time-out
  bool reopen = false;                      // when it is unplugged, or time-outs follow each other
  double shortest_pause = 0.5;              // s before the first attempt to open it again
  double longest_pause = 5;                 // s
  std::optional<double> interval;           // s between two frames of the camera, if known
  std::optional<PlaneMap> plane_map;        // default: the frames show exactly the area
  std::optional<std::pair<int, int>> area;  // px; default: that of the frames
  std::optional<std::pair<int, int>> size;  // px; default: that of the first frame
  int headings = 0;                         // of the frames of a simulated camera, as in Frame
};

struct CaptureCounts {
  std::int64_t grabbed = 0;    // complete frames that came
  std::int64_t delivered = 0;  // taken by a reader
  std::int64_t dropped = 0;    // overwritten by a newer one before a reader took them
  std::int64_t torn = 0;       // torn or short
  std::int64_t timeouts = 0;   // a frame_timeout without a frame
  std::int64_t reopened = 0;
};

/// Reads a camera in a thread of its own, continuously, and keeps its newest frame. A reader gets
/// each frame at most once, never a torn one.
///
/// The clock of the frames starts at the first one.
class Grabber {
 public:
  Grabber(std::shared_ptr<CaptureDevice> device, const GrabberOptions& options);
  ~Grabber();
  Grabber(const Grabber&) = delete;
  Grabber& operator=(const Grabber&) = delete;

  /// Waits until a first frame has come, and returns its width and height; nothing after `timeout`
  /// s. Throws as `take` does.
  std::optional<std::pair<int, int>> wait_for_size(double timeout) const;

  /// The newest frame that nobody has taken yet; nothing if none comes within `timeout` s. Throws
  /// the CaptureError that ended the camera, after the last frame; std::invalid_argument if it is
  /// closed, and std::runtime_error in a forked process, which has no such thread.
  std::optional<Frame> take(double timeout);

  /// The frame that was taken last.
  std::optional<Frame> newest() const;

  CaptureCounts counts() const;

  /// The first rate that was a fraction of the promised one, and that one (1/s). Of 30 intervals in
  /// a row, more than 80 % were then the same multiple of the promised one.
  std::optional<std::pair<double, double>> kept_rate() const;

  /// Ends the thread and gives the camera back. A device that hangs is left behind after
  /// `patience` s: its thread ends when the call under way returns.
  void close(double patience = 1) noexcept;

 private:
  struct State;
  static void grab(const std::shared_ptr<State>& state);
  void check_process() const;

  std::shared_ptr<State> state_;
  std::unique_ptr<std::thread> thread_;
};

}  // namespace robsim
