// Value semantics of bound classes, by their fields: ==, hash, copy, pickle, repr.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

namespace robsim::bindings {

namespace py = pybind11;

/// A field of a value: its name in the repr ("" = a positional argument), and how it is read.
template <typename Get>
struct Field {
  Field(const char* name, Get get) : name(name), get(std::move(get)) {}

  const char* name;
  Get get;
};

/// The fields that together make up a value, and from which `make` makes it anew: with its checks,
/// since pickles come from elsewhere.
template <typename Make, typename... Gets>
struct Fields {
  Fields(Make make, Field<Gets>... fields) : make(std::move(make)), fields(std::move(fields)...) {}

  Make make;
  std::tuple<Field<Gets>...> fields;
};

/// What == returns: a bool, or NotImplemented, so that Python asks the other operand.
class Equality : public py::object {
 public:
  explicit Equality(bool value) : py::object(py::bool_(value)) {}
  explicit Equality(py::handle value) : py::object(py::reinterpret_borrow<py::object>(value)) {}
};

/// The fields of a value in Python, in their order.
template <typename T, typename Make, typename... Gets>
py::tuple values_of(const T& value, const Fields<Make, Gets...>& fields) {
  return std::apply(
      [&](const auto&... field) { return py::make_tuple(std::invoke(field.get, value)...); },
      fields.fields);
}

/// Field values as a key: tuples in place of lists, shape and bytes in place of an array, None in
/// place of NaN, which equals nothing.
inline py::object key_of(py::handle value) {
  if (py::isinstance<py::array>(value)) {
    return py::make_tuple(value.attr("shape"), value.attr("tobytes")());
  }
  if (py::isinstance<py::float_>(value) && std::isnan(value.cast<double>())) return py::none();
  if (!py::isinstance<py::list>(value) && !py::isinstance<py::tuple>(value)) {
    return py::reinterpret_borrow<py::object>(value);
  }
  const auto items = py::reinterpret_borrow<py::sequence>(value);
  py::tuple key(items.size());
  for (std::size_t i = 0; i < items.size(); ++i) key[i] = key_of(items[i]);
  return std::move(key);
}

/// What a class of the user's own that builds on a value has added to it.
inline py::dict own_attributes(py::handle self) {
  return py::getattr(self, "__dict__", py::dict()).cast<py::dict>();
}

/// ==: the same type and the same fields; NaN equals NaN.
template <typename Class, typename... F>
void define_equality(Class& cls, const Fields<F...>& fields) {
  using T = typename Class::type;
  cls.def("__eq__", [fields](const py::object& self, const py::object& other) {
    if (!py::type::of(self).is(py::type::of(other))) {
      return Equality(py::handle(Py_NotImplemented));
    }
    if (self.is(other)) return Equality(true);
    const auto key = [&](const py::object& value) {
      return key_of(values_of(value.cast<const T&>(), fields));
    };
    return Equality(key(self).equal(key(other)) &&
                    own_attributes(self).equal(own_attributes(other)));
  });
}

/// hash: for what never changes.
template <typename Class, typename... F>
void define_hash(Class& cls, const Fields<F...>& fields) {
  using T = typename Class::type;
  cls.def("__hash__",
          [fields](const T& self) { return py::hash(key_of(values_of(self, fields))); });
}

/// pickle, copy and deepcopy.
template <typename Class, typename Make, typename... Gets>
void define_pickle(Class& cls, const Fields<Make, Gets...>& fields) {
  using T = typename Class::type;
  const auto get = [fields](const py::object& self) -> py::object {
    return py::make_tuple(values_of(self.cast<const T&>(), fields), own_attributes(self));
  };
  const auto set = [make = fields.make](const py::object& state) {
    const auto [values, attributes] = state.cast<std::pair<py::tuple, py::dict>>();
    auto arguments =
        values.cast<std::tuple<std::decay_t<std::invoke_result_t<Gets, const T&>>...>>();
    return std::make_pair(std::apply(make, std::move(arguments)), attributes);
  };
  cls.def(py::pickle(get, set));
  // object's own would make one without asking its class, and crash.
  cls.def("__reduce__", [](const py::object& self) {
    const py::object make = py::module_::import("copyreg").attr("__newobj__");
    return py::make_tuple(make, py::make_tuple(py::type::of(self)), self.attr("__getstate__")());
  });
}

/// repr: DriveAround(low=-0.5, high=1.5, hold=10), or with the name of a static method that takes
/// the fields: MarkerLayout.from_positions(...).
template <typename Class, typename... F>
void define_repr(Class& cls, const Fields<F...>& fields, const std::string& maker = "") {
  using T = typename Class::type;
  cls.def("__repr__", [fields, maker](const py::object& self) {
    const py::tuple values = values_of(self.cast<const T&>(), fields);
    std::string text;
    std::size_t i = 0;
    const auto add = [&](const char* name) {
      text += (i ? ", " : "") + std::string(name) + (*name ? "=" : "");
      text += py::repr(values[i++]).cast<std::string>();
    };
    std::apply([&](const auto&... field) { (add(field.name), ...); }, fields.fields);
    const auto type = py::type::of(self).attr("__name__").cast<std::string>();
    return type + (maker.empty() ? "" : "." + maker) + "(" + text + ")";
  });
}

/// All of these: for a class whose objects never change.
template <typename Class, typename... F>
void define_value(Class& cls, const Fields<F...>& fields, const std::string& maker = "") {
  define_equality(cls, fields);
  define_hash(cls, fields);
  define_pickle(cls, fields);
  define_repr(cls, fields, maker);
}

}  // namespace robsim::bindings

template <>
struct pybind11::detail::handle_type_name<robsim::bindings::Equality> {
  static constexpr auto name = const_name("bool");
};
