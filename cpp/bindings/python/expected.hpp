// What an argument of a native function must be: for the error that names it.
#pragma once

#include <limits>
#include <map>

#include "python/numpy.hpp"

namespace robsim::bindings {

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
std::string many_of() {
  if constexpr (is_converted<T>) {
    return "values";
  } else {
    return Expected<T>::many();
  }
}

template <typename T>
struct Expected<std::shared_ptr<T>> : Expected<T> {};

template <typename T>
struct Expected<std::optional<T>> {
  static std::string text(py::handle value) { return Expected<T>::text(value) + " or None"; }
  static std::string many() { return Expected<T>::many() + " or None"; }
};

template <typename T>
struct Expected<std::vector<T>> {
  static std::string text(py::handle) { return "a list of " + many_of<T>(); }
  static std::string many() { return "lists of " + many_of<T>(); }
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
  static std::string text(py::handle) { return "a dict of names to " + many_of<T>(); }
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

template <typename T>
constexpr bool is_dict_of_converted = false;
template <typename T>
constexpr bool is_dict_of_converted<std::map<std::string, T>> = is_converted<T>;

/// Throws an error that names the argument unless a value can be given for it.
template <typename T>
void check(py::handle value, const std::string& name) {
  using Given = typename NotNone<T>::type;
  if constexpr (is_converted<Given>) {
    if (std::is_same_v<T, Given> || !value.is_none()) Conversion<Given>::from(value, name);
  } else {
    if constexpr (is_dict_of_converted<Given>) {
      if (PyDict_Check(value.ptr())) {
        for (const auto& [key, item] : py::reinterpret_borrow<py::dict>(value)) {
          check<typename Given::mapped_type>(item, name + "[" + describe(key) + "]");
        }
      }
    }
    if (accepts<T>(value)) return;
    throw py::type_error(name + " must be " + Expected<T>::text(value) + ", got " +
                         describe(value));
  }
}

}  // namespace robsim::bindings
