#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>

#include "robsim/imaging/resampling.hpp"
#include "robsim/lab/capture/capture_device.hpp"
#include "robsim/lab/laboratory/camera_faults.hpp"
#include "robsim/lab/laboratory/laboratory.hpp"
#include "robsim/world/scene.hpp"
#include "robsim/world/visual_noise.hpp"

namespace robsim {

/// From a scene, seen from above, to the frame of a camera elsewhere, by the map of its pixels.
Warp view_warp(const Scene& scene, int width, int height, const PlaneMap& plane_map);

/// The robot's flat top, at a height above the floor, as a camera elsewhere sees it.
class RaisedRobot {
 public:
  /// `warp` leads from the scene, seen from above, to the frame: that of the plane at the height.
  RaisedRobot(std::shared_ptr<const Scene> scene, std::shared_ptr<const Warp> warp);

  /// Draws it over a frame of the floor.
  void draw(const Pose& pose, const WritableView& frame);

 private:
  // The scene with nothing but the robot, before one colour.
  struct Cutout {
    Image image;
    std::uint8_t color;

    void fill(const PixelBox& box);
  };

  std::shared_ptr<const Scene> scene_;
  std::shared_ptr<const Warp> warp_;
  Cutout black_, white_;
};

struct LaboratoryCameraOptions {
  std::shared_ptr<const Warp> warp;  // from the scene to the frame; null: the scene is the frame
  VisualNoise noise;
  std::uint64_t noise_seed = 0;
  double delay = 0;  // of a frame, from its exposure on, s
  CameraFaults faults;
  std::shared_ptr<const Warp> top;  // of the robot's top above the floor; null: it lies on it
};

/// The camera of a laboratory: it exposes at each tick. One that comes too late to draw a frame
/// skips it; a frame whose fault is to come late comes late, and those behind it after it.
class LaboratoryCamera : public CaptureDevice {
 public:
  /// `scene` is what there is to see, from above.
  LaboratoryCamera(std::shared_ptr<Laboratory> laboratory, std::shared_ptr<const Scene> scene,
                   const LaboratoryCameraOptions& options);
  ~LaboratoryCamera() override { close(); }

  void open() override;
  std::optional<Captured> next(ImagePool& pool) override;
  void close() noexcept override;
  void interrupt() noexcept override;

 private:
  bool wait_for(std::int64_t k, double due, double deadline);
  double since_start(std::int64_t k) const { return static_cast<double>(k) * laboratory_->dt(); }
  bool is_lost(std::int64_t k, double due) const;
  Captured captured(std::int64_t k, ImagePool& pool);
  Image picture(std::int64_t k, ImagePool& pool);
  void draw_raised(const Image& scene, const Laboratory::Tick& tick, const WritableView& frame);
  Image torn(const Image& whole, std::int64_t k, ImagePool& pool) const;

  const std::shared_ptr<Laboratory> laboratory_;
  const LaboratoryCameraOptions options_;
  Renderer renderer_;
  std::optional<RaisedRobot> raised_;
  Image floor_;  // below a raised robot, as the camera sees it
  std::atomic<bool> is_interrupted_{false};
  bool is_open_ = false;
  std::int64_t next_ = 0;         // the tick whose frame comes next
  double last_due_ = 0;           // when the one before was to come, monotonic, s
  Image last_;                    // the last whole picture
  std::int64_t last_shown_ = -1;  // its tick
};

}  // namespace robsim
