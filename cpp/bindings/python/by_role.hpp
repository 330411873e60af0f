// What the two markers of a robot have, by their roles: dicts in Python, pairs in C++.
#pragma once

#include <pybind11/typing.h>

#include <map>

#include "python/numpy.hpp"
#include "robsim/vision/marker_roles.hpp"

namespace robsim::bindings {

template <typename T>
using ByRole = std::map<std::string, T>;

/// Whether a dict has these roles, and nothing else.
template <typename T>
bool has_roles(const ByRole<T>& values, MarkerRoles roles) {
  const auto& [first, second] = names_of(roles);
  return values.size() == 2 && values.count(first) && values.count(second);
}

/// Refuses a dict given as the argument `name`: it is not by the roles that are expected.
template <typename T>
[[noreturn]] void refuse_roles(const ByRole<T>& values, const char* name,
                               const std::string& expected) {
  py::list got;
  for (const auto& entry : values) got.append(entry.first);
  throw py::value_error(std::string(name) + " must be a dict with the roles " + expected +
                        ", got " + describe(got));
}

/// The roles of a dict.
template <typename T>
MarkerRoles roles_of(const ByRole<T>& values, const char* name) {
  for (const MarkerRoles roles : all_marker_roles) {
    if (has_roles(values, roles)) return roles;
  }
  refuse_roles(values, name, "'right' and 'left', or 'front' and 'back'");
}

/// Refuses a dict that has something of other markers; one of these may be left out.
template <typename T>
void check_roles(const ByRole<T>& values, MarkerRoles roles, const char* name) {
  const auto& [first, second] = names_of(roles);
  if (values.size() == values.count(first) + values.count(second)) return;
  refuse_roles(values, name, "'" + first + "' and '" + second + "' of these markers");
}

/// The values of the first and the second marker, which must both be there.
template <typename T>
std::array<T, 2> in_order(const ByRole<T>& values, MarkerRoles roles, const char* name) {
  const auto& [first, second] = names_of(roles);
  if (has_roles(values, roles)) return {values.at(first), values.at(second)};
  refuse_roles(values, name, "'" + first + "' and '" + second + "' of these markers");
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
