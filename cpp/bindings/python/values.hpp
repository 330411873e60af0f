// Values of bound classes, by their fields: constructor, properties, ==, hash, copy, pickle, repr.
#pragma once

#include <cmath>
#include <functional>

#include "python/signature.hpp"

namespace robsim::bindings {

/// A figure that may be unknown: None in Python, NaN here.
inline std::optional<double> known(double value) {
  return std::isnan(value) ? std::nullopt : std::optional(value);
}

/// In a field's place: it has no default, and must be given.
struct Required {};

/// A field of a value: its name, how it is read, its property's docstring (none: no property), and
/// the default of the constructor's argument.
template <typename Get, typename Default = Required>
struct Field {
  Field(const char* name, Get get, const char* doc = nullptr, Default fallback = {})
      : name(name), get(std::move(get)), doc(doc), fallback(std::move(fallback)) {}

  const char* name;
  Get get;
  const char* doc;
  Default fallback;
};

/// Among the fields: the ones behind it are arguments by name alone, and the repr names them.
constexpr py::kw_only by_name{};

/// The fields that together make up a value, and from which `make` makes it again: with its
/// checks, since pickles may come from outside.
template <typename Make, typename... F>
struct Fields {
  Fields(Make make, F... fields) : make(std::move(make)), fields(std::move(fields)...) {}

  Make make;
  std::tuple<F...> fields;

  /// Calls a function for each field.
  template <typename Call>
  void for_each(const Call& call) const {
    const auto call_for = [&](const auto& field) {
      if constexpr (!std::is_same_v<std::decay_t<decltype(field)>, py::kw_only>) call(field);
    };
    std::apply([&](const auto&... field) { (call_for(field), ...); }, fields);
  }
};

/// Makes an object by setting its members, then calls a function that checks it.
template <typename T, typename... M>
auto maker(void (*check)(const T&), M T::*... members) {
  return [=](const M&... values) {
    T made;
    ((made.*members = values), ...);
    if (check) check(made);
    return made;
  };
}

/// Fields that all are members.
template <typename T, typename... F>
auto members(void (*check)(const T&), F... fields) {
  const auto member = [](const auto& field) {
    if constexpr (std::is_same_v<std::decay_t<decltype(field)>, py::kw_only>) {
      return std::tuple<>();
    } else {
      return std::tuple(field.get);
    }
  };
  const auto make = [&](auto... get) { return maker<T>(check, get...); };
  return Fields(std::apply(make, std::tuple_cat(member(fields)...)), fields...);
}

/// The constructor and its arguments.
template <typename Class, typename Make, typename... F>
void define_constructor(Class& cls, const Fields<Make, F...>& fields) {
  const auto argument = [](const auto& field) {
    using Type = std::decay_t<decltype(field)>;
    if constexpr (std::is_same_v<Type, py::kw_only>) {
      return field;
    } else if constexpr (std::is_same_v<decltype(field.fallback), Required>) {
      return py::arg(field.name);
    } else {
      // Else True would be a number, and any object a truth.
      return py::arg(field.name).noconvert(std::is_same_v<decltype(field.fallback), bool>) =
                 field.fallback;
    }
  };
  std::apply(
      [&](const auto&... field) { cls.def(py::init(Make(fields.make)), argument(field)...); },
      fields.fields);
}

/// The properties.
template <typename Class, typename... F>
void define_properties(Class& cls, const Fields<F...>& fields) {
  using T = typename Class::type;
  fields.for_each([&](const auto& field) {
    const auto get = [get = field.get](const T& self) -> decltype(auto) {
      return std::invoke(get, self);
    };
    if (field.doc) cls.def_property_readonly(field.name, get, field.doc);
  });
}

/// What == returns: a bool, or NotImplemented, so that Python asks the other operand.
class Equality : public py::object {
 public:
  explicit Equality(bool value) : py::object(py::bool_(value)) {}
  explicit Equality(py::handle value) : py::object(py::reinterpret_borrow<py::object>(value)) {}
};

/// The fields of a value in Python, in their order: lists instead of arrays of numbers.
template <typename T, typename... F>
py::tuple values_of(const T& value, const Fields<F...>& fields) {
  py::list values;
  fields.for_each([&](const auto& field) {
    values.append(std::invoke(field.get, value));
    const py::object last = values[values.size() - 1];
    if (py::isinstance<py::array_t<double>>(last))
      values[values.size() - 1] = last.attr("tolist")();
  });
  return values;
}

/// Field values as a key: tuples for lists, shape and bytes for an image, None for NaN.
inline py::object key_of(py::handle value) {
  if (py::isinstance<py::array_t<double>>(value)) return key_of(value.attr("tolist")());
  if (py::isinstance<py::array>(value)) {
    return py::make_tuple(value.attr("shape"), value.attr("tobytes")());
  }
  if (py::isinstance<py::dict>(value)) return key_of(py::list(value.attr("items")()));
  if (py::isinstance<py::float_>(value) && std::isnan(value.cast<double>())) return py::none();
  if (!py::isinstance<py::list>(value) && !py::isinstance<py::tuple>(value)) {
    return py::reinterpret_borrow<py::object>(value);
  }
  const auto items = py::reinterpret_borrow<py::sequence>(value);
  py::tuple key(items.size());
  for (std::size_t i = 0; i < items.size(); ++i) key[i] = key_of(items[i]);
  return std::move(key);
}

/// The attributes that a user's subclass has added to a value.
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
template <typename Class, typename Make, typename... F>
void define_pickle(Class& cls, const Fields<Make, F...>& fields) {
  using T = typename Class::type;
  const auto get = [fields](const py::object& self) -> py::object {
    return py::make_tuple(values_of(self.cast<const T&>(), fields), own_attributes(self));
  };
  const auto set = [make = fields.make](const py::object& state) {
    try {
      const auto [values, attributes] = state.cast<std::pair<py::tuple, py::dict>>();
      auto arguments = values.cast<typename ArgumentTypes<Make>::type>();
      return std::make_pair(std::apply(make, std::move(arguments)), attributes);
    } catch (const py::cast_error&) {
      throw py::type_error("state must be what __getstate__ returned, got " + describe(state));
    }
  };
  cls.def(py::pickle(get, set));
  // object's own would make one without asking its class, and crash.
  cls.def("__reduce__", [](const py::object& self) {
    const py::object make = py::module_::import("copyreg").attr("__newobj__");
    return py::make_tuple(make, py::make_tuple(py::type::of(self)), self.attr("__getstate__")());
  });
}

/// repr: DriveAround(low=-0.5, high=1.5, hold=10); those before `by_name` without a name.
template <typename Class, typename... F>
void define_repr(Class& cls, const Fields<F...>& fields) {
  using T = typename Class::type;
  cls.def("__repr__", [fields](const py::object& self) {
    const py::tuple values = values_of(self.cast<const T&>(), fields);
    std::string text;
    std::size_t i = 0;
    bool is_named = !(std::is_same_v<F, py::kw_only> || ...);
    const auto add = [&](const auto& field) {
      if constexpr (std::is_same_v<std::decay_t<decltype(field)>, py::kw_only>) {
        is_named = true;
      } else {
        text += (i ? ", " : "") + (is_named ? field.name + std::string("=") : "");
        text += py::repr(values[i++]).template cast<std::string>();
      }
    };
    std::apply([&](const auto&... field) { (add(field), ...); }, fields.fields);
    return py::type::of(self).attr("__name__").cast<std::string>() + "(" + text + ")";
  });
}

/// repr: a format of str.format, in which {0} is the object.
template <typename Class>
void define_repr(Class& cls, const char* format) {
  cls.def("__repr__", [format](const py::object& self) { return py::str(format).format(self); });
}

/// All that a class has whose objects never change, but its constructor and repr.
template <typename Class, typename... F>
void define_record(Class& cls, const Fields<F...>& fields) {
  define_properties(cls, fields);
  define_equality(cls, fields);
  define_hash(cls, fields);
  define_pickle(cls, fields);
}

/// The same, with the constructor.
template <typename Class, typename... F>
void define_value(Class& cls, const Fields<F...>& fields) {
  define_constructor(cls, fields);
  define_record(cls, fields);
}

}  // namespace robsim::bindings

template <>
struct pybind11::detail::handle_type_name<robsim::bindings::Equality> {
  static constexpr auto name = const_name("bool");
};
