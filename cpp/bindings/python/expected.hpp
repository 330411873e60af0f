// Expected types of the arguments of native functions, for their errors.
#pragma once

#include <limits>
#include <map>

#include "python/numpy.hpp"

namespace robsim::bindings {

template <typename T>
struct Type {};

template <typename T>
std::string class_name() {
  return py::type::of<T>().attr("__name__").template cast<std::string>();
}

/// Several values of a type.
inline std::string many(Type<bool>) { return "bools"; }
inline std::string many(Type<std::string>) { return "str"; }
template <typename T>
std::string many(Type<T>) {
  if constexpr (std::is_arithmetic_v<T>) {
    return std::is_integral_v<T> ? "ints" : "numbers";
  } else if constexpr (is_converted<T> || std::is_base_of_v<py::handle, T>) {
    return "values";
  } else {
    return class_name<T>() + " objects";
  }
}
template <typename T>
std::string many(Type<std::shared_ptr<T>>) {
  return many(Type<T>());
}
template <typename T>
std::string many(Type<std::optional<T>>) {
  return many(Type<T>()) + " or None";
}
template <typename T>
std::string many(Type<std::vector<T>>) {
  return "lists of " + many(Type<T>());
}

/// The words behind "must be" for an argument of a type.
inline std::string expected(Type<bool>, py::handle) { return "True or False"; }
inline std::string expected(Type<std::string>, py::handle) { return "a str"; }
inline std::string expected(Type<py::str>, py::handle) { return "a str"; }
template <typename T>
std::string expected(Type<T>, py::handle value) {
  if constexpr (std::is_integral_v<T>) {
    if (!PyLong_Check(value.ptr())) return "an int";
    using Limits = std::numeric_limits<T>;  // an int it is, but too large
    return "an int within " + std::to_string(Limits::min()) + ".." + std::to_string(Limits::max());
  } else if constexpr (std::is_floating_point_v<T>) {
    return "a number";
  } else if constexpr (std::is_base_of_v<py::handle, T>) {
    return std::string("of type ") + py::detail::make_caster<T>::name.text;
  } else {
    const std::string name = class_name<T>();
    return (std::string("AEIOU").find(name.front()) < 5 ? "an " : "a ") + name;
  }
}
template <typename T, int flags>
std::string expected(Type<py::array_t<T, flags>>, py::handle) {
  return "an array of " + many(Type<T>());
}
template <typename T>
std::string expected(Type<std::shared_ptr<T>>, py::handle value) {
  return expected(Type<T>(), value);
}
template <typename T>
std::string expected(Type<std::optional<T>>, py::handle value) {
  return expected(Type<T>(), value) + " or None";
}
template <typename T>
std::string expected(Type<std::vector<T>>, py::handle) {
  return "a list of " + many(Type<T>());
}
template <typename T, std::size_t size>
std::string expected(Type<std::array<T, size>>, py::handle) {
  return "a sequence of " + std::to_string(size) + " " + many(Type<T>());
}
template <typename T>
std::string expected(Type<std::pair<T, T>>, py::handle) {
  return "two " + many(Type<T>());
}
template <typename T>
std::string expected(Type<std::map<std::string, T>>, py::handle) {
  return "a dict of names to " + many(Type<T>());
}

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
    throw py::type_error(name + " must be " + expected(Type<T>(), value) + ", got " +
                         describe(value));
  }
}

}  // namespace robsim::bindings
