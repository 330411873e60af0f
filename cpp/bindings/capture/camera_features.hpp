#pragma once

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "python/interpreter.hpp"
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

}  // namespace robsim::bindings
