#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "robsim/imaging/image.hpp"

namespace robsim {

/// What can be wrong with a camera. After `time_out` the next frame may still come; `end` is that
/// of a file, and no fault.
enum class CaptureFault {
  no_back_end,
  no_bus,
  no_permission,
  no_camera,
  no_bandwidth,
  busy,
  time_out,
  unplugged,
  end,
  failed
};

/// The fault of a name, "time_out" of CaptureFault::time_out; `failed` where there is none.
CaptureFault fault_of(const std::string& name);
const char* name_of(CaptureFault fault);

class CaptureError : public std::runtime_error {
 public:
  CaptureError(CaptureFault fault, const std::string& text)
      : std::runtime_error(text), fault_(fault) {}

  CaptureFault fault() const { return fault_; }

 private:
  CaptureFault fault_;
};

/// What a camera delivers.
struct Captured {
  Image image;
  double arrived = 0;                 // monotonic, s
  std::optional<double> device_time;  // s, of the device's own clock
  std::optional<double> exposed;      // monotonic, s, where the device knows it
  bool is_complete = true;            // false: torn or short, for nobody to see
  std::int64_t passed = 0;            // complete ones before it that came too fast to be seen
  std::int64_t torn = 0;              // others before it that were not
};

/// A camera of any kind. The thread of a grabber calls it, one call at a time; `interrupt` comes
/// from others.
class CaptureDevice {
 public:
  virtual ~CaptureDevice() = default;

  /// Makes it ready to deliver; again after `close`, too. Throws CaptureError.
  virtual void open() = 0;

  /// The next frame in an image of the pool; nothing after 0.1 s or so without one: the grabber
  /// asks again. Throws CaptureError.
  virtual std::optional<Captured> next(ImagePool& pool) = 0;

  /// Gives everything back. May follow a failed `open`, and `close`.
  virtual void close() noexcept = 0;

  /// Ends a call under way early, if it can.
  virtual void interrupt() noexcept {}
};

/// What is asked of a feature of a camera: to be automatic, or a value.
struct FeatureWish {
  std::string name;  // "shutter"
  bool is_automatic = false;
  std::vector<double> values;  // one; of the white balance two: blue, red
};

/// How a feature is set.
struct FeatureState {
  std::string name;
  bool is_automatic = false;
  std::vector<double> values;  // one; of the white balance two: blue, red
  std::string unit;            // "s", "dB"; "": as the camera counts
  double low = 0, high = 0;
};

/// Earlier wishes, but for those of features that later ones are about, and the later ones.
std::vector<FeatureWish> overlaid(const std::vector<FeatureWish>& earlier,
                                  const std::vector<FeatureWish>& later);

/// Throws CaptureError that names the feature and its limits unless a camera can have the values
/// of a wish. `slack` is a part of the limits by which a value may pass them.
void check_values(const FeatureWish& wish, const FeatureState& state, double slack = 0);

}  // namespace robsim
