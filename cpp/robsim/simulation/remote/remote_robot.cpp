#include "robsim/simulation/remote/remote_robot.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "robsim/base/system.hpp"
#include "robsim/simulation/robot/stages.hpp"

namespace robsim {

namespace {

constexpr std::size_t blobs_of_a_color = 2;  // that are recorded

// The blobs as far as they are recorded: none is searched here.
BlobsByColor blobs_from(const std::vector<Point>& centroids,
                        const std::vector<ColorClass>& colors) {
  BlobsByColor blobs;
  for (const ColorClass& color : colors) blobs[color.name];
  if (centroids.size() < blobs_of_a_color * blobs.size()) return blobs;
  auto next = centroids.begin();
  for (auto& [color, found] : blobs) {
    for (std::size_t i = 0; i < blobs_of_a_color; ++i, ++next) {
      if (std::isnan(next->x)) continue;
      Blob blob;
      blob.color = color;
      blob.centroid = *next;
      found.push_back(blob);
    }
  }
  return blobs;
}

}  // namespace

std::optional<AxisMatrix> RemoteRobot::estimate_parameters(const StepPointer& step) {
  return answer(step, parameters_bit).parameters;
}

std::optional<Measurement> RemoteRobot::measure(const StepPointer& step) {
  const StepMessage& known = answer(step, measure_bit);
  step->blobs = blobs_from(known.blobs, step->colors());
  if (known.missed && !known.measurement) {
    Detection detection;
    detection.result = *known.missed;
    detection.markers = step->markers();
    step->detection = detection;
  }
  return known.measurement;
}

Estimate RemoteRobot::estimate_state(const StepPointer& step) {
  const StepMessage& known = answer(step, estimate_bit);
  if (!known.estimate) refuse(estimate_bit, step->k, "there must be an estimate, got none");
  const std::size_t size = known.estimate->state.size();
  if (step->k == 0) states_ = 0;
  if (size > 0 && states_ > 0 && size != states_) {
    refuse(estimate_bit, step->k,
           "state must have " + std::to_string(states_) + " numbers at every step, got " +
               std::to_string(size));
  }
  if (size > 0) states_ = size;
  return *known.estimate;
}

Input RemoteRobot::control(const StepPointer& step) {
  const StepMessage& known = answer(step, control_bit);
  if (!known.u) refuse(control_bit, step->k, "there must be an input, got none");
  return *known.u;
}

const StepMessage& RemoteRobot::answer(const StepPointer& pointer, StageBit stage) {
  Step& step = *pointer;
  if (answer_.k == step.k && answer_.done & stage) return answer_;
  if (options_.measures_first && step.has_frame && !step.measurement) {
    step.measurement = step.detect();
  }
  const StepMessage message = question(step, stage);
  const bool has_pixels = message.frame && message.frame->slot < 0;
  const ImageView pixels = has_pixels ? step.look()->image.view() : ImageView{};
  const std::string bytes =
      exchange_(to_bytes(message), has_pixels ? &pixels : nullptr, slot_of(stage), step.k);
  try {
    answer_ = message_from(bytes.data(), bytes.size());
  } catch (const MessageError& error) {
    refuse(error.stage().value_or(stage), step.k, error.what());
  }
  check(answer_, step, stage);
  if (!options_.memory.empty()) options_.choose_memory(answer_.next_slot);
  return answer_;
}

StepMessage RemoteRobot::question(Step& step, StageBit stage) const {
  StepMessage message;
  message.k = step.k;
  message.t = step.t;
  message.last_u = step.last_u;
  message.done = before(stage) | (options_.measures_first ? measure_bit : 0U);
  message.has_frame = step.has_frame;
  message.frame = frame_of(step);
  if (options_.sends_samples) message.sample = step.find_sample();
  message.parameters = step.parameters;
  message.measurement = step.measurement;
  message.estimate = step.estimate;
  return message;
}

std::optional<FrameMessage> RemoteRobot::frame_of(Step& step) const {
  if (!options_.sends_frames || !step.has_frame) return std::nullopt;
  const Frame& frame = *step.look();
  const auto& memory = options_.memory;
  const auto found = std::find(memory.begin(), memory.end(), frame.image.row(0));
  const auto slot = found == memory.end() ? -1 : static_cast<std::int32_t>(found - memory.begin());
  return FrameMessage{slot, frame.index, frame.t.value_or(step.t), frame.headings, frame.plane_map};
}

void RemoteRobot::check(const StepMessage& answer, const Step& step, StageBit stage) const {
  if (answer.k != step.k) {
    refuse(stage, step.k,
           "the answer must be that to this step, got one to step " + std::to_string(answer.k));
  }
  if (!(answer.done & stage)) refuse(stage, step.k, "there must be an answer, got none");
  if (answer.frame) refuse(stage, step.k, "an answer must have no frame");
  if (!answer.blobs.empty() && answer.blobs.size() != blobs_of_a_color * step.colors().size()) {
    refuse(measure_bit, step.k, "there must be two blobs of each colour");
  }
  if (!options_.memory.empty() && answer.next_slot >= options_.memory.size()) {
    refuse(stage, step.k, "the memory of the next frame must be one that there is");
  }
  if (!answer.u) return;
  const double most = std::max(std::abs(answer.u->u1), std::abs(answer.u->u2));
  if (most > options_.largest_input) {
    refuse(control_bit, step.k,
           "the input must be at most " + to_text(options_.largest_input) + " V, got " +
               to_text(most) + " V");
  }
}

void RemoteRobot::refuse(StageBit stage, std::int64_t k, const std::string& what) const {
  refuse_(slot_of(stage), k, what);
  throw std::logic_error(what);
}

AxisMatrix RemoteEstimator::update(Step&) {
  throw std::logic_error("the parameters are estimated in another process");
}

bool RemoteEstimator::write_standard_errors_unscaled(double* errors) const {
  const std::optional<AxisMatrix>& known = robot_->standard_errors_unscaled();
  if (known) std::copy_n(known->data(), 15, errors);
  return known.has_value();
}

}  // namespace robsim
