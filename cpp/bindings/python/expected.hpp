// What an argument of a native function must be: for the error that names it.
#pragma once

#include <pybind11/pybind11.h>

#include <array>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace robsim::bindings {

namespace py = pybind11;

/// The sentence for type T: `text` follows "must be", `many` names several of them.
template <typename T, typename = void>
struct Expected {  // a class of the core
  static std::string name() {
    return py::type::of<T>().attr("__name__").template cast<std::string>();
  }
  static std::string text(py::handle) {
    const bool is_vowel = std::string("AEIOU").find(name().front()) != std::string::npos;
    return (is_vowel ? "an " : "a ") + name();
  }
  static std::string many() { return name() + " objects"; }
};

template <typename T>
struct Expected<T,
                std::enable_if_t<std::is_base_of_v<py::handle, T> && !std::is_same_v<T, py::str>>> {
  static std::string text(py::handle) {
    return std::string("of type ") + py::detail::make_caster<T>::name.text;
  }
  static std::string many() { return "values"; }
};

template <>
struct Expected<bool> {
  static std::string text(py::handle) { return "True or False"; }
  static std::string many() { return "bools"; }
};

template <typename T>
struct Expected<T, std::enable_if_t<std::is_floating_point_v<T>>> {
  static std::string text(py::handle) { return "a number"; }
  static std::string many() { return "numbers"; }
};

template <typename T>
struct Expected<T, std::enable_if_t<std::is_integral_v<T> && !std::is_same_v<T, bool>>> {
  static std::string text(py::handle value) {
    if (!PyLong_Check(value.ptr())) return "an int";
    using Limits = std::numeric_limits<T>;  // an int it is, but too large
    return "an int within " + std::to_string(Limits::min()) + ".." + std::to_string(Limits::max());
  }
  static std::string many() { return "ints"; }
};

template <typename T>
struct Expected<T, std::enable_if_t<std::is_same_v<T, std::string> || std::is_same_v<T, py::str>>> {
  static std::string text(py::handle) { return "a str"; }
  static std::string many() { return "str"; }
};

template <typename T>
struct Expected<std::shared_ptr<T>> : Expected<T> {};

template <typename T>
struct Expected<std::optional<T>> {
  static std::string text(py::handle value) { return Expected<T>::text(value) + " or None"; }
  static std::string many() { return Expected<T>::many() + " or None"; }
};

template <typename T>
struct Expected<std::vector<T>> {
  static std::string text(py::handle) { return "a list of " + Expected<T>::many(); }
  static std::string many() { return "lists of " + Expected<T>::many(); }
};

template <typename T, std::size_t size>
struct Expected<std::array<T, size>> {
  static std::string text(py::handle) {
    return "a sequence of " + std::to_string(size) + " " + Expected<T>::many();
  }
};

template <typename T>
struct Expected<std::pair<T, T>> {
  static std::string text(py::handle) { return "two " + Expected<T>::many(); }
};

template <typename T>
struct Expected<std::map<std::string, T>> {
  static std::string text(py::handle) { return "a dict of names to " + Expected<T>::many(); }
};

template <typename T>
struct NotNone {
  using type = T;
};
template <typename T>
struct NotNone<std::optional<T>> {
  using type = T;
};

/// Whether a value can be given for an argument of type T. It is stricter than pybind11, which
/// takes a bool for a number, anything for a bool, bytes for text and None for a class.
template <typename T>
bool accepts(py::handle value) {
  using Given = typename NotNone<T>::type;
  constexpr bool is_optional = !std::is_same_v<T, Given>;
  constexpr bool is_anything = std::is_base_of_v<py::handle, Given>;
  if (value.is_none() && !is_anything) return is_optional;
  if constexpr (std::is_arithmetic_v<Given> && !std::is_same_v<Given, bool>) {
    if (PyBool_Check(value.ptr())) return false;
  }
  if constexpr (std::is_same_v<Given, std::string>) return PyUnicode_Check(value.ptr());
  return py::detail::make_caster<Given>().load(value, !std::is_same_v<Given, bool>);
}

}  // namespace robsim::bindings
