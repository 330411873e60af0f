#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "robsim/imaging/image.hpp"
#include "robsim/simulation/remote/step_message.hpp"
#include "robsim/simulation/seam/world.hpp"

namespace robsim {

/// Frames in memory that another process writes, mapped read-only: one after the other, in slots.
/// Where there are no such mappings (Windows), making one throws std::runtime_error.
class SharedFrames {
 public:
  /// `descriptor` stays open as long as this lives. Every slot takes `slot_bytes`, a multiple of
  /// the size of a page. Throws std::system_error if it cannot be mapped.
  SharedFrames(int descriptor, int slots, std::size_t slot_bytes, int width, int height);

  /// The image in a slot: what the other process has written there. Throws std::out_of_range.
  Image image(int slot);

  /// A slot that the other process may write to while this one is looked at: one whose image
  /// nobody holds. If there is none, whoever holds that of the next slot keeps what it shows now,
  /// at the same address.
  int free_beside(int slot);

 private:
  void let_go(Image& image);

  int descriptor_;
  std::size_t slot_bytes_;
  int width_, height_;
  std::vector<Image> images_;  // empty: not mapped
};

/// The world half in another process, which is asked for each step, and the stages there that come
/// between those here.
class RemoteWorld : public World {
 public:
  struct Options {
    std::uint32_t stages = 0;              // that are filled here, as bits
    std::shared_ptr<SharedFrames> frames;  // null: pixels follow the messages, if they are sent
    int width = 0, height = 0;             // of the frames, px
  };

  /// Sends a message, unless it is empty, and returns the next one; nothing at the end.
  using Exchange = std::function<std::optional<std::string>(const std::string& message)>;

  RemoteWorld(Options options, Exchange exchange)
      : options_(std::move(options)), exchange_(std::move(exchange)) {}

  void start(const RobotModel& model) override { dt_ = model.dt(); }
  void reset() override {}
  Arrival next(std::int64_t k, Observation& observation) override;
  Sent send(std::int64_t, const Input& u) override { return {u, std::nullopt}; }
  bool is_interpreted() const override { return true; }

  /// Throws std::runtime_error if frames are not sent.
  Frame frame() override;

  // The stages of the other process, whose results this one is told.
  std::optional<AxisMatrix> estimate_parameters(const StepPointer& step);
  std::optional<Measurement> measure(const StepPointer& step);
  Estimate estimate_state(const StepPointer& step);

  /// Notes what the stages here gave, which goes out at once when the loop asks for the next step.
  void end_step(const Step& step);

 private:
  const StepMessage& told(const StepPointer& step, StageBit stage);
  bool take_step(std::int64_t k);
  bool ask(const std::string& answer);
  StepMessage answer(const Step& step, std::uint32_t done) const;

  Options options_;
  Exchange exchange_;
  double dt_ = 0;       // s
  std::string answer_;  // to be sent; empty: none
  StepMessage message_;
  std::string pixels_;  // that followed it
  std::optional<Frame> frame_;
  std::uint32_t next_slot_ = 0;  // for the next frame
};

}  // namespace robsim
