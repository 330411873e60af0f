#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "robsim/model/robot_model.hpp"
#include "robsim/simulation/seam/observation.hpp"
#include "robsim/simulation/seam/thread_guard.hpp"
#include "robsim/simulation/seam/world.hpp"
#include "robsim/world/scene.hpp"
#include "robsim/world/visual_noise.hpp"
#include "robsim/world/work_area.hpp"

namespace robsim {

/// What moves the robot beside its model: normal noise on the pose, and on what the motors get.
struct Disturbance {
  Eigen::Matrix3d pose_factor = Eigen::Matrix3d::Zero();  // L, covariance of a step = L L'
  std::array<double, 2> input_sigma = {0, 0};             // V
  bool is_on = false;                                     // one of them is not 0
  std::uint64_t seed = 0;

  /// What the motors get in step k in place of u.
  Input disturbed(const Input& u, std::int64_t k) const;

  /// Where the robot is in step k in place of the pose.
  Pose disturbed(const Pose& pose, std::int64_t k) const;
};

/// What a robot model gets to compute the pose of step k.
struct WorldState {
  std::int64_t k = 0;
  double t = 0;   // s
  double dt = 0;  // s
  Pose pose_1;    // of step k-1
  Pose pose_2;    // of step k-2
  Input last_u;   // that acted from step k-1 to step k
  RobotModel model;
};

/// Something hides the robot from the camera: with this probability throughout each segment of so
/// many steps.
struct Dropout {
  double probability = 0;
  int steps = 1;
  std::uint64_t seed = 0;

  bool hides(std::int64_t k) const;
};

struct WorldOptions {
  WorkArea area;
  PlaneMap camera;            // of the view before it is displaced
  int width = 0, height = 0;  // of the frames, px
  double robot_radius = 0;    // of the robot's outline around its centre, work-area px
  Pose start;
  VisualNoise noise;
  std::uint64_t noise_seed = 0;
  Dropout dropout;
  Disturbance disturbance;
  int camera_delay = 0;    // steps
  double motor_delay = 0;  // steps

  /// Calls `visit(name, member)` for each option that Python sets by its name.
  template <typename Visit>
  static void each(const Visit& visit) {
    visit("robot_radius", &WorldOptions::robot_radius);
    visit("noise", &WorldOptions::noise);
    visit("camera_delay", &WorldOptions::camera_delay);
    visit("motor_delay", &WorldOptions::motor_delay);
  }
};

/// The slots of the world half.
struct WorldSlots {
  Slot<Pose(const WorldState&)> evaluate_model;              // empty: the robot's model
  std::function<std::shared_ptr<const Scene>()> make_scene;  // called when somebody first looks
  bool makes_scene_at_start = false;                         // nevertheless

  // The model that the robot follows, from the one that the robot half believes in; empty: the
  // same.
  std::function<RobotModel(const RobotModel&)> true_model;
};

/// The simulated world: a robot on a work area under a camera.
class SimulatedWorld : public World {
 public:
  /// Throws std::invalid_argument unless the start is a finite pose.
  explicit SimulatedWorld(const WorldOptions& options);

  const WorldOptions& options() const { return options_; }
  WorldSlots& slots() { return slots_; }

  /// The model that the robot follows; nothing before the start.
  const std::optional<RobotModel>& model() const { return model_; }

  // To be changed before the start, or between two steps.
  template <typename T>
  void set(T WorldOptions::* option, const T& value) {
    const RunGuard::Look look(guard());
    options_.*option = value;
  }
  void set_start(const Pose& start);
  void set_dropout(double probability, int steps);
  void set_disturbance(const Eigen::Matrix3d& pose_factor, std::array<double, 2> input_sigma);
  void set_seeds(std::uint64_t noise, std::uint64_t dropout, std::uint64_t disturbance);

  /// Has the noise of the frame captured at step k drawn from the k-th of these keys, each a seed
  /// of its own, in place of the seed of all and the step; empty: no longer. There must be one for
  /// each step.
  void set_noise_keys(std::vector<std::uint64_t> keys);

  /// Has the newest frames drawn on one of these images of their size, whoever holds it: memory
  /// that another process sees, where a frame with noise is never shown without it.
  void set_frame_memory(const std::vector<Image>& images);
  std::vector<Image> frame_memory() const;

  /// Says on which of them the next frame is drawn. Throws std::out_of_range.
  void choose_frame_memory(std::size_t index);

  /// Lets the scene be made anew for the next frame; earlier ones are drawn with it, too.
  void forget_scene();

  /// What the camera looks at; null if nobody has looked yet.
  std::shared_ptr<const Scene> scene() const { return renderer_ ? renderer_->scene() : nullptr; }

  /// Draws the frame of a step on a canvas of the size of the frames, or on images of the world.
  Frame draw(const Truth& captured, Renderer::Canvas* canvas = nullptr);

  /// The step that the newest frame shows; null if none has come yet.
  const Truth* newest_captured() const;

  void start(const RobotModel& model) override;
  void reset() override;
  Arrival next(std::int64_t k, Observation& observation) override;
  Sent send(std::int64_t k, const Input& u) override;
  const Truth* truth() const override { return &truth_; }
  bool has_moving_view() const override { return options_.area.boundary == Boundary::unlimited; }
  bool is_interpreted() const override { return slots_.evaluate_model.is_interpreted; }
  Frame frame() override;

 private:
  void move_robot(std::int64_t k);
  void capture(std::int64_t k);
  Pose next_pose(std::int64_t k);
  Input acting_input(std::int64_t k) const;
  void follow_robot();
  Renderer& renderer();
  std::int64_t pixel_count() const { return std::int64_t{options_.width} * options_.height; }
  void add_noise(const Truth& captured, const ImageView& clean, const WritableView& noisy) const;

  WorldOptions options_;
  WorldSlots slots_;
  std::optional<RobotModel> model_;
  std::optional<Renderer> renderer_;
  ImagePool noisy_images_;
  std::vector<std::uint64_t> noise_keys_;
  std::vector<Renderer::Canvas> memory_;  // for the newest frames; empty: none is given
  std::size_t next_in_memory_ = 0;

  // The last two poses: bounces mirror them together.
  Pose last_pose_;
  Truth truth_;
  Pan pan_;
  // Of the last steps, step k at k modulo the size.
  std::vector<Input> sent_;
  std::vector<Truth> captured_;
};

}  // namespace robsim
