#include "robsim/simulation/world/simulated_world.hpp"

#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "robsim/base/elementary/elementary.hpp"
#include "robsim/simulation/seam/thread_guard.hpp"

namespace robsim {

namespace {
constexpr std::uint64_t draws_per_step = 5;  // three for the pose, two for the motors

double draw(std::uint64_t seed, std::int64_t k, std::uint64_t i) {
  return random_normal(seed, draws_per_step * static_cast<std::uint64_t>(k) + i);
}
}  // namespace

Input Disturbance::disturbed(const Input& u, std::int64_t k) const {
  return {u.u1 + input_sigma[0] * draw(seed, k, 3), u.u2 + input_sigma[1] * draw(seed, k, 4)};
}

Pose Disturbance::disturbed(const Pose& pose, std::int64_t k) const {
  const std::array<double, 3> n = {draw(seed, k, 0), draw(seed, k, 1), draw(seed, k, 2)};
  // w = L n, with L lower triangular
  const auto& L = pose_factor;
  return {pose.x + L(0, 0) * n[0], pose.y + (L(1, 0) * n[0] + L(1, 1) * n[1]),
          pose.heading + ((L(2, 0) * n[0] + L(2, 1) * n[1]) + L(2, 2) * n[2])};
}

namespace {

// What is remembered of a step, in a ring.
template <typename Ring>
auto& at_step(Ring& ring, std::int64_t k) {
  return ring[ring.size() == 1 ? 0 : static_cast<std::size_t>(k) % ring.size()];  // % is slow
}

}  // namespace

bool Dropout::hides(std::int64_t k) const {
  return probability > 0 &&
         random_uniform(seed, static_cast<std::uint64_t>(k / steps)) < probability;
}

SimulatedWorld::SimulatedWorld(const WorldOptions& options) : options_(options) {
  set_start(options.start);
}

void SimulatedWorld::set_start(const Pose& start) {
  if (!is_finite(start)) {
    throw std::invalid_argument("start must be a finite pose, got NaN or inf");
  }
  const RunGuard::Look look(guard());
  options_.start = start;
  options_.start.heading = wrap_angle(start.heading);
}

void SimulatedWorld::set_dropout(double probability, int steps) {
  const RunGuard::Look look(guard());
  options_.dropout.probability = probability;
  options_.dropout.steps = steps;
}

void SimulatedWorld::set_disturbance(const Eigen::Matrix3d& pose_factor,
                                     std::array<double, 2> input_sigma) {
  const RunGuard::Look look(guard());
  options_.disturbance.pose_factor = pose_factor;
  options_.disturbance.input_sigma = input_sigma;
  options_.disturbance.is_on = !pose_factor.isZero(0) || input_sigma[0] != 0 || input_sigma[1] != 0;
}

void SimulatedWorld::set_seeds(std::uint64_t noise, std::uint64_t dropout,
                               std::uint64_t disturbance) {
  const RunGuard::Look look(guard());
  options_.noise_seed = noise;
  options_.dropout.seed = dropout;
  options_.disturbance.seed = disturbance;
}

void SimulatedWorld::set_noise_keys(std::vector<std::uint64_t> keys) {
  const RunGuard::Look look(guard());
  noise_keys_ = std::move(keys);
}

void SimulatedWorld::set_frame_memory(const std::vector<Image>& images) {
  const RunGuard::Look look(guard());
  memory_.clear();
  next_in_memory_ = 0;
  for (const Image& image : images) {
    if (image.width() != options_.width || image.height() != options_.height) {
      throw std::invalid_argument("the memory must have the size of the frames");
    }
    memory_.push_back({image, image.box(), {}});
  }
}

std::vector<Image> SimulatedWorld::frame_memory() const {
  std::vector<Image> images;
  for (const Renderer::Canvas& canvas : memory_) images.push_back(canvas.image);
  return images;
}

void SimulatedWorld::choose_frame_memory(std::size_t index) {
  if (index >= memory_.size()) throw std::out_of_range("there is no such memory for a frame");
  next_in_memory_ = index;
}

void SimulatedWorld::forget_scene() {
  renderer_.reset();
  for (Renderer::Canvas& canvas : memory_) canvas.dirty = canvas.image.box();
}

void SimulatedWorld::start(const RobotModel& model) {
  model_ = slots_.true_model ? slots_.true_model(model) : model;
  if (slots_.makes_scene_at_start) renderer();
  truth_ = {};
  truth_.pose = last_pose_ = options_.start;
  pan_ = {};
  sent_.assign(static_cast<std::size_t>(std::ceil(options_.motor_delay)) + 1, {});
  captured_.assign(static_cast<std::size_t>(options_.camera_delay) + 1, {});
  capture(0);
}

void SimulatedWorld::reset() {
  model_.reset();
  forget_scene();
}

Arrival SimulatedWorld::next(std::int64_t k, Observation& observation) {
  if (k > 0) move_robot(k);
  capture(k);
  observation.t = static_cast<double>(k) * model_->dt();
  observation.has_frame = newest_captured() != nullptr;
  return Arrival::step;
}

void SimulatedWorld::capture(std::int64_t k) {
  if (has_moving_view()) follow_robot();
  truth_.k = k;
  truth_.hidden = options_.dropout.hides(k);
  truth_.noise = options_.noise.percent();
  if (options_.camera_delay > 0) at_step(captured_, k) = truth_;
}

Sent SimulatedWorld::send(std::int64_t k, const Input& u) {
  at_step(sent_, k) = u;
  return {u, std::nullopt};
}

void SimulatedWorld::move_robot(std::int64_t k) {
  Pose now = next_pose(k);
  now.heading = wrap_angle(now.heading);
  if (!is_finite(now)) {
    throw std::runtime_error("the robot's pose has grown beyond all bounds at step " +
                             std::to_string(k) + ": are the inputs bounded?");
  }
  last_pose_ = truth_.pose;
  truth_.pose = now;
  truth_.bounced = options_.area.boundary == Boundary::bounce &&
                   bounce(options_.area, options_.robot_radius, truth_.pose, last_pose_);
}

Pose SimulatedWorld::next_pose(std::int64_t k) {
  const Disturbance& disturbance = options_.disturbance;
  Input u = acting_input(k - 1);
  if (disturbance.is_on) u = disturbance.disturbed(u, k);
  Pose pose;
  if (slots_.evaluate_model) {
    truth_.turn.reset();  // it may have been filled since the last step
    const double dt = model_->dt();
    pose = slots_.evaluate_model.call(
        {k, static_cast<double>(k) * dt, dt, truth_.pose, last_pose_, u, *model_});
  } else {
    truth_.turn = elementary::sin_cos(truth_.pose.heading);
    pose = model_->predict(truth_.pose, last_pose_, u, truth_.turn);
  }
  if (disturbance.is_on) pose = disturbance.disturbed(pose, k);
  return pose;
}

// The mean of the inputs that act from step k to step k + 1.
Input SimulatedWorld::acting_input(std::int64_t k) const {
  const auto sent = [&](std::int64_t step) { return step < 0 ? Input{} : at_step(sent_, step); };
  if (options_.motor_delay == 0) return sent(k);
  const double n = std::floor(options_.motor_delay), f = options_.motor_delay - n;
  const std::int64_t newest = k - static_cast<std::int64_t>(n);
  const Input u = sent(newest);
  if (f == 0) return u;
  // u_acting(k) = (1 - f) u(k - n) + f u(k - n - 1), with the delay n + f
  const Input before = sent(newest - 1);
  return {(1 - f) * u.u1 + f * before.u1, (1 - f) * u.u2 + f * before.u2};
}

void SimulatedWorld::follow_robot() {
  const PlaneMap& camera = options_.camera;
  const Point pixel = camera.to_pixel({truth_.pose.x, truth_.pose.y});
  const double margin = 2 * options_.robot_radius / std::sqrt(camera.area_scale({}));
  pan_ = follow(pan_, pixel, options_.width, options_.height, margin);
  truth_.view = {camera.matrix()[0] * pan_.u, camera.matrix()[4] * pan_.v};
}

const Truth* SimulatedWorld::newest_captured() const {
  if (options_.camera_delay == 0) return &truth_;
  const std::int64_t arrived = truth_.k - options_.camera_delay;
  return arrived < 0 ? nullptr : &at_step(captured_, arrived);
}

Renderer& SimulatedWorld::renderer() {
  if (!renderer_) renderer_.emplace(slots_.make_scene());
  return *renderer_;
}

Frame SimulatedWorld::frame() {
  const Truth* captured = newest_captured();
  if (!captured) throw std::runtime_error("there is no frame yet: run a step");
  return draw(*captured, memory_.empty() ? nullptr : &memory_[next_in_memory_]);
}

void SimulatedWorld::add_noise(const Truth& captured, const ImageView& clean,
                               const WritableView& noisy) const {
  VisualNoise noise = options_.noise;
  if (noise.percent() != captured.noise)
    noise = VisualNoise(captured.noise);  // its tables are slow
  const auto k = static_cast<std::uint64_t>(captured.k);
  if (noise_keys_.empty()) {
    noise.add(clean, options_.noise_seed, k, noisy);
  } else if (k < noise_keys_.size()) {
    noise.add(clean, noise_keys_[k], 0, noisy);
  } else {
    throw std::out_of_range("there is no key for the noise of step " + std::to_string(k));
  }
}

Frame SimulatedWorld::draw(const Truth& captured, Renderer::Canvas* canvas) {
  const PlaneMap::Matrix& camera = options_.camera.matrix();
  const Pan pan{static_cast<int>(std::lround(captured.view.x / camera[0])),
                static_cast<int>(std::lround(captured.view.y / camera[4]))};
  const auto pose = captured.hidden ? std::nullopt : std::optional(captured.pose);
  Frame frame;
  frame.t = static_cast<double>(captured.k) * model_->dt();
  frame.index = captured.k;
  frame.plane_map = renderer().plane_map(pan);
  frame.headings = renderer().scene()->headings();
  const NativeWork native(pixel_count());
  if (captured.noise == VisualNoise::Percent{}) {
    frame.image = canvas ? renderer().render(pose, pan, *canvas) : renderer().render(pose, pan);
    return frame;
  }
  const Image clean = renderer().render(pose, pan);
  frame.image = canvas ? canvas->image : noisy_images_.take(clean.width(), clean.height());
  if (canvas) canvas->dirty = canvas->image.box();
  add_noise(captured, clean.view(), frame.image.writable_view());
  return frame;
}

}  // namespace robsim
