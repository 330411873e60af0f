// Values of a robot's two markers, by their roles: dicts in Python, pairs in C++.
#pragma once

#include <pybind11/typing.h>

#include <map>

#include "python/numpy.hpp"
#include "robsim/vision/marker_roles.hpp"

namespace robsim::bindings {

template <typename T>
using ByRole = std::map<std::string, T>;

/// Refuses a dict given as the argument `name`, unless it has the roles of markers, both or
/// `at_least` one, and nothing else. Returns the first of the choices that it has.
template <typename T>
MarkerRoles checked_roles(const ByRole<T>& values, std::initializer_list<MarkerRoles> choices,
                          const char* name, std::size_t at_least = 2) {
  std::string expected;
  for (const MarkerRoles roles : choices) {
    const auto& [first, second] = names_of(roles);
    const std::size_t known = values.count(first) + values.count(second);
    if (known == values.size() && known >= at_least) return roles;
    expected += (expected.empty() ? "'" : ", or '") + first + "' and '" + second + "'";
  }
  py::list got;
  for (const auto& entry : values) got.append(entry.first);
  throw py::value_error(std::string(name) + " must be a dict with the roles " + expected +
                        " of markers, got " + describe(got));
}

/// The roles of a dict.
template <typename T>
MarkerRoles roles_of(const ByRole<T>& values, const char* name) {
  return checked_roles(values, {MarkerRoles::right_left, MarkerRoles::front_back}, name);
}

/// The values of the first and the second marker, which must both be there.
template <typename T>
std::array<T, 2> in_order(const ByRole<T>& values, MarkerRoles roles, const char* name) {
  checked_roles(values, {roles}, name);
  return {values.at(names_of(roles)[0]), values.at(names_of(roles)[1])};
}

/// The dict of both, the first marker before the second.
template <typename Annotated, typename T>
py::typing::Dict<py::str, Annotated> by_role(MarkerRoles roles, const T& first, const T& second) {
  py::typing::Dict<py::str, Annotated> result;
  result[names_of(roles)[0].c_str()] = first;
  result[names_of(roles)[1].c_str()] = second;
  return result;
}

}  // namespace robsim::bindings
