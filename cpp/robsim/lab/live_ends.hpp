#pragma once

#include <memory>

#include "robsim/lab/capture/grabber.hpp"
#include "robsim/lab/motors/motor_link.hpp"
#include "robsim/simulation/world/external_world.hpp"

namespace robsim {

/// The newest frame of a camera each time. Throws as Grabber::take.
FrameSource frames_of(std::shared_ptr<Grabber> camera);

/// A robot behind a line. The link keeps the error of a stop that fails.
InputSink inputs_to(std::shared_ptr<MotorLink> link);

}  // namespace robsim
