#pragma once

#include <dc1394/dc1394.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "robsim/lab/capture/capture_device.hpp"

namespace robsim::fire_wire {

/// A camera on the bus.
struct FoundCamera {
  std::string guid;  // 16 hexadecimal digits
  std::string vendor, model;
};

/// The device nodes of FireWire.
struct Nodes {
  std::vector<std::string> readable;  // "/dev/fw1"
  std::vector<std::string> denied;    // to this user
};
Nodes nodes();

/// All cameras that this user may read, in the order of their numbers. Throws CaptureError.
std::vector<FoundCamera> find_cameras();

/// The camera of a choice: "" is the first one, "1" the second one, 16 digits a certain one. Throws
/// CaptureError: no bus, no permission, no camera.
class CameraHandle {
 public:
  explicit CameraHandle(const std::string& choice);

  dc1394camera_t* get() const { return camera_.get(); }
  std::string guid() const;

 private:
  std::unique_ptr<dc1394_t, decltype(&dc1394_free)> library_;
  std::unique_ptr<dc1394camera_t, decltype(&dc1394_camera_free)> camera_;
};

/// Throws CaptureError unless a call of the library went well: "could not set the frame rate: ...".
void check(dc1394error_t error, const std::string& action);

/// The fastest speed between this computer and a camera: of its card, of the camera, and of what is
/// between them, as the kernel knows it. Nothing where it does not tell.
std::optional<dc1394speed_t> link_speed(std::uint64_t guid);

}  // namespace robsim::fire_wire
