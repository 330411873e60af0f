#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "robsim/imaging/plane_map.hpp"
#include "robsim/simulation/robot/step.hpp"

namespace robsim {

/// The stages of the robot half, as bits.
enum StageBit : std::uint32_t {
  parameters_bit = 1,
  measure_bit = 2,
  estimate_bit = 4,
  control_bit = 8,
};

/// The name of the slot of a stage.
const char* slot_of(StageBit stage);

/// The stages that come before this one.
inline std::uint32_t before(StageBit stage) { return stage - 1U; }

/// A frame without its pixels.
struct FrameMessage {
  std::int32_t slot = -1;  // where they lie in the shared memory; -1: they follow the message
  std::int64_t index = 0;
  double t = 0;  // s
  std::int32_t headings = 0;
  PlaneMap plane_map;
};

/// A step on its way between the process of the world half and that of the robot half: what is
/// known of it by now.
struct StepMessage {
  std::int64_t k = -1;     // no step yet
  double t = 0;            // s
  Input last_u;            // that the robot really got
  std::uint32_t done = 0;  // stages, as bits: what they gave counts
  bool has_frame = false;  // one has come, whether it is sent or not
  std::optional<FrameMessage> frame;
  std::optional<Sample> sample;
  std::optional<AxisMatrix> parameters;
  std::optional<AxisMatrix> standard_errors_unscaled;
  std::optional<Measurement> measurement;  // without its pair of blobs
  std::optional<DetectionResult> missed;   // what the default measurement said without one
  std::vector<Point> blobs;  // centroids (px of the frame), two of each colour, NaN = none
  std::optional<Estimate> estimate;
  std::optional<Input> u;
  std::uint32_t next_slot = 0;  // for the next frame: whose memory nobody looks at any more
};

/// Bytes that are no message, or say what cannot be.
class MessageError : public std::invalid_argument {
 public:
  /// `stage`: of which stage that is; nothing: of none.
  explicit MessageError(const std::string& what, std::optional<StageBit> stage = std::nullopt)
      : std::invalid_argument(what), stage_(stage) {}

  std::optional<StageBit> stage() const { return stage_; }

 private:
  std::optional<StageBit> stage_;
};

/// Its bytes: little endian, a part of fixed size, the blobs, the further state.
std::string to_bytes(const StepMessage& message);

/// The message of bytes that somebody wrote who is not to be trusted: of the length that they say,
/// with finite numbers, counts and choices that there are, covariances that can be. The pixels that
/// follow a frame that is in no slot take `pixel_bytes`. Throws MessageError.
StepMessage message_from(const char* bytes, std::size_t size, std::size_t pixel_bytes = 0);

}  // namespace robsim
