// The halves of a loop in two processes, with the callables that exchange their messages.
#pragma once

#include <pybind11/stl.h>

#include <string>
#include <utility>

#include "python/callbacks.hpp"
#include "robsim/simulation/remote/remote_robot.hpp"
#include "robsim/simulation/remote/remote_world.hpp"

namespace robsim::bindings {

/// They do not keep the callables alive: the values do, where the garbage collector sees them.
class PythonRemoteRobot : public RemoteRobot, public SlotValues {
 public:
  PythonRemoteRobot(Options options, const py::object& exchange, const py::object& refuse)
      : RemoteRobot(std::move(options), by(exchange), refusal(refuse)) {
    values = {{"exchange", exchange}, {"refuse", refuse}};
  }

 private:
  static Exchange by(py::handle exchange) {
    return [exchange](const std::string& message, const ImageView* pixels, const char* slot,
                      std::int64_t k) {
      py::object following = py::none();
      if (pixels) following = image_array(copy_of(*pixels));
      return exchange(py::bytes(message), following, slot, k).cast<std::string>();
    };
  }
  static Refuse refusal(py::handle refuse) {
    return [refuse](const char* slot, std::int64_t k, const std::string& what) {
      refuse(slot, k, what);
    };
  }
};

class PythonRemoteWorld : public RemoteWorld, public SlotValues {
 public:
  PythonRemoteWorld(Options options, const py::object& exchange)
      : RemoteWorld(std::move(options), by(exchange)) {
    values = {{"exchange", exchange}};
  }

 private:
  static Exchange by(py::handle exchange) {
    return [exchange](const std::string& message) {
      return exchange(py::bytes(message)).cast<std::optional<std::string>>();
    };
  }
};

}  // namespace robsim::bindings
