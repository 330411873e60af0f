#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <utility>

#include "robsim/simulation/robot/step.hpp"
#include "robsim/simulation/seam/world.hpp"

namespace robsim {

/// Frames and detections of a run, for other runs of the same world and seed, one after the other.
/// As long as the robot takes the same path, these have the same frames.
class Sights {
 public:
  /// The known frame of this truth; null if it is missing.
  std::shared_ptr<const Sight> at(const Truth& truth) const;

  /// Keeps the frame of a step, if there is room: frames take up to 128 MB.
  void keep(const Truth& truth, const Step& step);

 private:
  std::map<std::int64_t, std::pair<Truth, std::shared_ptr<const Sight>>> by_step_;
  std::size_t bytes_ = 0;
};

}  // namespace robsim
