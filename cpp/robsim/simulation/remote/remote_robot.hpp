#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "robsim/simulation/remote/step_message.hpp"
#include "robsim/simulation/robot/stages.hpp"

namespace robsim {

/// A robot half in another process, which nobody trusts, as stages of the loop here. Stages that
/// follow each other there take one exchange of messages.
class RemoteRobot {
 public:
  struct Options {
    std::uint32_t stages = 0;  // that it fills, as bits
    bool sends_frames = false;
    bool sends_samples = true;                // for its parameter estimator
    bool measures_first = false;              // the default measurement, here, before it is asked
    bool has_standard_errors = false;         // of its parameters
    double largest_input = 0;                 // V
    std::vector<const std::uint8_t*> memory;  // of the frames in its slots, as the process sees it
    std::function<void(std::size_t)> choose_memory;  // the slot of the next frame
  };

  /// Sends a message for the stage of a slot at step k, with the pixels that follow it, if it has
  /// any, and returns the answer.
  using Exchange = std::function<std::string(const std::string& message, const ImageView* pixels,
                                             const char* slot, std::int64_t k)>;

  /// Throws: the answer of a stage cannot be used.
  using Refuse = std::function<void(const char* slot, std::int64_t k, const std::string& what)>;

  RemoteRobot(Options options, Exchange exchange, Refuse refuse)
      : options_(std::move(options)), exchange_(std::move(exchange)), refuse_(std::move(refuse)) {}

  // The stages. They throw what `exchange` and `refuse` throw.
  std::optional<AxisMatrix> estimate_parameters(const StepPointer& step);
  std::optional<Measurement> measure(const StepPointer& step);
  Estimate estimate_state(const StepPointer& step);
  Input control(const StepPointer& step);

  bool has_standard_errors() const { return options_.has_standard_errors; }
  const std::optional<AxisMatrix>& standard_errors_unscaled() const {
    return answer_.standard_errors_unscaled;
  }

 private:
  const StepMessage& answer(const StepPointer& step, StageBit stage);
  StepMessage question(Step& step, StageBit stage) const;
  void check(const StepMessage& answer, const Step& step, StageBit stage) const;
  std::optional<FrameMessage> frame_of(Step& step) const;
  [[noreturn]] void refuse(StageBit stage, std::int64_t k, const std::string& what) const;

  Options options_;
  Exchange exchange_;
  Refuse refuse_;
  StepMessage answer_;
  std::size_t states_ = 0;  // the size of the further state, once there is one
};

/// The parameter estimator of a robot half in another process, which must outlive it.
class RemoteEstimator : public ParameterEstimator {
 public:
  explicit RemoteEstimator(const RemoteRobot& robot) : robot_(&robot) {}

  AxisMatrix update(Step& step) override;
  bool has_standard_errors() const override { return robot_->has_standard_errors(); }
  bool write_standard_errors_unscaled(double* errors) const override;

 private:
  const RemoteRobot* robot_;
};

}  // namespace robsim
