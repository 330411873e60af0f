#pragma once

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <chrono>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include "python/interpreter.hpp"
#include "robsim/base/system.hpp"
#include "robsim/lab/capture/capture_device.hpp"

namespace robsim::bindings {

/// (name, values, or None for automatic)
using Wishes = std::vector<std::pair<std::string, std::optional<std::vector<double>>>>;

inline std::vector<FeatureWish> wishes_from(const Wishes& given) {
  std::vector<FeatureWish> wishes;
  for (const auto& [name, values] : given) {
    wishes.push_back({name, !values, values.value_or(std::vector<double>())});
  }
  return wishes;
}

using FeatureTuple =
    std::tuple<std::string, bool, std::vector<double>, std::string, double, double>;

template <typename Camera>
std::vector<FeatureTuple> features_of(const Camera& camera) {
  std::vector<FeatureState> states;
  {
    const WithoutInterpreter work;
    states = camera.features();
  }
  std::vector<FeatureTuple> found;
  for (const FeatureState& state : states) {
    found.emplace_back(state.name, state.is_automatic, state.values, state.unit, state.low,
                       state.high);
  }
  return found;
}

/// Gives the class of a camera its features, as Camera.features takes them.
template <typename Class>
void bind_features(Class& camera) {
  namespace py = pybind11;
  using Camera = typename Class::type;
  camera
      .def_property_readonly(
          "features", &features_of<Camera>,
          "list of tuple: name, whether it is automatic, values, unit, least, greatest value.")
      .def(
          "set_features",
          [](Camera& self, const Wishes& wishes) {
            const WithoutInterpreter work;
            self.set_features(wishes_from(wishes));
          },
          py::arg("wishes"), "Set features: pairs (name, values, or None for automatic).");
}

/// How the opening of a device goes on in a thread of its own.
struct Opening {
  std::mutex mutex;
  std::condition_variable changed;
  bool is_over = false;
  std::exception_ptr error;
};

/// Opens a device, which takes as long as it likes for its answers: Ctrl-C is heard meanwhile, and
/// after `patience` (s) nobody waits any more. Throws CaptureError.
inline void open_in_thread(const std::shared_ptr<CaptureDevice>& device, double patience = 30) {
  constexpr std::chrono::milliseconds look(100);
  const auto opening = std::make_shared<Opening>();
  std::thread thread = start_thread([device, opening] {
    std::exception_ptr error;
    try {
      device->open();
    } catch (...) {
      error = std::current_exception();
    }
    const std::lock_guard<std::mutex> lock(opening->mutex);
    opening->error = error;
    opening->is_over = true;
    opening->changed.notify_all();
  });
  const double end = monotonic_now() + patience;
  while (true) {
    {
      const WithoutInterpreter work;
      std::unique_lock<std::mutex> lock(opening->mutex);
      if (opening->changed.wait_for(lock, look, [&] { return opening->is_over; })) {
        lock.unlock();
        thread.join();
        if (opening->error) std::rethrow_exception(opening->error);
        return;
      }
    }
    // The thread has the device until it answers, and gives it back then.
    if (PyErr_CheckSignals()) {
      thread.detach();
      throw pybind11::error_already_set();
    }
    if (monotonic_now() > end) {
      thread.detach();
      throw CaptureError(CaptureFault::no_camera,
                         "the camera has answered, but too slowly to be opened within " +
                             std::to_string(static_cast<int>(patience)) +
                             " s: switch it off and on");
    }
  }
}

}  // namespace robsim::bindings
