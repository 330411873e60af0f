#include "robsim/lab/live_ends.hpp"

#include <utility>

#include "robsim/simulation/seam/thread_guard.hpp"

namespace robsim {

namespace {
constexpr double longest_take = 0.05;  // s, after which the loop looks whether it was stopped
}  // namespace

FrameSource frames_of(std::shared_ptr<Grabber> camera) {
  const auto take = [camera = std::move(camera)](std::int64_t, Arrived& arrived) {
    const NativeWork native;
    try {
      arrived.frame = camera->take(longest_take);
    } catch (const CaptureError& error) {
      if (error.fault() != CaptureFault::end) throw;
      return Arrival::end;
    }
    return arrived.frame ? Arrival::step : Arrival::nothing_yet;
  };
  return {take, true, false};
}

InputSink inputs_to(std::shared_ptr<MotorLink> link) {
  const auto send = [link](std::int64_t, const Input& u) {
    const NativeWork native;
    return std::optional(link->send(u));
  };
  const auto stop = [link] {
    const NativeWork native;
    return link->stop_quietly() ? std::optional(Input{}) : std::nullopt;
  };
  return {send, stop, [link] { link->halt(); }, false, [link] { return link->is_silent(); }};
}

}  // namespace robsim
