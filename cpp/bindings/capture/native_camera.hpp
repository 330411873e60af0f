#pragma once

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <chrono>
#include <future>
#include <memory>
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
  std::vector<FeatureTuple> found;
  for (const FeatureState& state : natively([&] { return camera.features(); })) {
    found.emplace_back(state.name, state.is_automatic, state.values, state.unit, state.low,
                       state.high);
  }
  return found;
}

/// Opens a device, which may answer late: Ctrl-C works meanwhile, and the wait ends after
/// `patience` (s). Throws CaptureError.
inline void open_in_thread(const std::shared_ptr<CaptureDevice>& device, double patience = 30) {
  constexpr std::chrono::milliseconds look(100);
  const auto opening = std::make_shared<std::packaged_task<void()>>([device] { device->open(); });
  std::future<void> opened = opening->get_future();
  std::thread thread = start_thread([opening] { (*opening)(); });
  const double end = monotonic_now() + patience;
  while (true) {
    {
      const WithoutInterpreter work;
      if (opened.wait_for(look) == std::future_status::ready) {
        thread.join();
        return opened.get();
      }
    }
    const bool is_interrupted = PyErr_CheckSignals() != 0;
    if (!is_interrupted && monotonic_now() <= end) continue;
    thread.detach();  // it has the device until that answers, and gives it back then
    if (is_interrupted) throw pybind11::error_already_set();
    throw CaptureError(CaptureFault::no_camera,
                       "the camera has answered, but too slowly to be opened within " +
                           std::to_string(static_cast<int>(patience)) + " s: switch it off and on");
  }
}

/// Gives the class of a camera its methods, with features as Camera.features takes them.
template <typename Class>
void bind_camera(Class& camera) {
  namespace py = pybind11;
  using Camera = typename Class::type;
  camera
      .def(
          "open", [](const std::shared_ptr<Camera>& self) { open_in_thread(self); },
          "Start it, so that the format of its frames is known. Raises CaptureError.")
      .def("close", &Camera::close, py::call_guard<WithoutInterpreter>(), "Give it back.")
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

}  // namespace robsim::bindings
