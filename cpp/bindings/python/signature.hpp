// Signatures of native functions: for inspect and help, and for errors that name the argument.
#pragma once

#include <algorithm>
#include <initializer_list>
#include <tuple>

#include "python/expected.hpp"

namespace robsim::bindings {

using namespace py::literals;

/// A parameter as a caller sees it.
struct Parameter {
  std::string name;
  bool is_keyword_only = false;
  py::object default_value;  // null: no default
  void (*check)(py::handle, const std::string& name) = nullptr;
};

/// The types of a callable's arguments, as a tuple.
template <typename F>
struct ArgumentTypes : ArgumentTypes<decltype(&F::operator())> {};
template <typename R, typename... A>
struct ArgumentTypes<R (*)(A...)> {
  using type = std::tuple<std::decay_t<A>...>;
};
template <typename C, typename R, typename... A>
struct ArgumentTypes<R (C::*)(A...)> : ArgumentTypes<R (*)(A...)> {};
template <typename C, typename R, typename... A>
struct ArgumentTypes<R (C::*)(A...) const> : ArgumentTypes<R (*)(A...)> {};

/// The parameters of a function, from its definition for pybind11. A template is compiled for each
/// function, so code that depends on no type is in the source file.
class ParameterList {
 public:
  template <typename... T, typename... Extra>
  explicit ParameterList(const std::tuple<T...>*, const Extra&... extra) {
    (add(extra), ...);
    set_checks({check_of<T>()...});
  }

  const std::vector<Parameter>& get() const { return list_; }

 private:
  using Check = decltype(Parameter::check);

  template <typename T>
  static constexpr Check check_of() {
    if constexpr (std::is_same_v<T, py::detail::value_and_holder>) {
      return nullptr;
    } else {
      return &check<T>;
    }
  }

  void add(const py::arg& argument);
  void add(const py::arg_v& argument);
  void add(const py::kw_only&) { is_keyword_only_ = true; }
  template <typename Other>
  void add(const Other&) {}
  void set_checks(std::initializer_list<Check> checks);

  std::vector<Parameter> list_;
  bool is_keyword_only_ = false;
};

template <typename F, typename... Extra>
ParameterList parameters_of(const Extra&... extra) {
  using Types = typename ArgumentTypes<std::decay_t<F>>::type;
  return ParameterList(static_cast<const Types*>(nullptr), extra...);
}

/// Lets `inspect.signature` know a native function of a module, or a static method of a class. A
/// call with wrong arguments raises a TypeError that names the argument, the expected and the
/// actual value. The function belongs to its owner like a Python function. Otherwise help would
/// call it a method of a pybind11 object, and it could not be pickled.
void sign_function(py::handle owner, const char* name, const ParameterList& parameters);

/// The same for a method; those that Python calls for an operator stay as they are.
void sign_method(py::handle owner, const char* name, const ParameterList& parameters);

/// As py::module_, for functions with signatures.
class Module : public py::module_ {
 public:
  explicit Module(const py::module_& module) : py::module_(module) {}

  template <typename F, typename... Extra>
  Module& def(const char* name, F&& f, const Extra&... extra) {
    py::module_::def(name, std::forward<F>(f), extra...);
    sign_function(*this, name, parameters_of<F>(extra...));
    return *this;
  }
};

/// A method: pickle's protocols 0 and 1 would make an object of pybind11's base class, which ends
/// the process.
inline py::object reduce_ex() {
  static const py::handle method =
      py::cpp_function(
          [](const py::object& self, int protocol) {
            const py::handle object(reinterpret_cast<PyObject*>(&PyBaseObject_Type));
            return object.attr("__reduce_ex__")(self, std::max(protocol, 2));
          },
          py::name("__reduce_ex__"), py::is_method(py::none()))
          .release();
  return py::reinterpret_borrow<py::object>(method);
}

/// As py::class_, for methods with signatures.
template <typename T, typename... Options>
class Class : public py::class_<T, Options...> {
  using Base = py::class_<T, Options...>;

 public:
  template <typename... Extra>
  explicit Class(const Extra&... extra) : Base(extra...) {
    this->attr("__reduce_ex__") = reduce_ex();
    // pybind11 calls this for the missing memory of an object without __init__.
    py::detail::get_type_info(typeid(T))->operator_new = [](std::size_t) -> void* {
      throw py::type_error("the object was made without its constructor");
    };
  }

  template <typename F, typename... Extra>
  Class& def(const char* name, F&& f, const Extra&... extra) {
    Base::def(name, std::forward<F>(f), extra...);
    sign_method(*this, name, parameters_of<F>(extra...));
    return *this;
  }

  /// py::init and py::pickle.
  template <typename Init, typename... Extra>
  auto def(Init&& init, const Extra&... extra)
      -> decltype(std::forward<Init>(init).execute(*this, extra...), *this) {
    std::forward<Init>(init).execute(*this, extra...);
    return *this;
  }

  template <typename F, typename... Extra>
  Class& def_static(const char* name, F&& f, const Extra&... extra) {
    Base::def_static(name, std::forward<F>(f), extra...);
    sign_function(*this, name, parameters_of<F>(extra...));
    return *this;
  }

  template <typename... Rest>
  Class& def_readonly(const char* name, const Rest&... rest) {
    Base::def_readonly(name, rest...);
    return *this;
  }
  template <typename Get, typename... Rest>
  Class& def_property_readonly(const char* name, const Get& get, const Rest&... rest) {
    // Of None, pybind11 would call a method of the class.
    const py::cpp_function getter(py::method_adaptor<T>(get), py::arg().none(false));
    Base::def_property_readonly(name, getter, py::return_value_policy::reference_internal, rest...);
    return *this;
  }
};

/// The module; the next bound objects name a public module as their home, such as
/// "robsim.vision": help, signatures and errors show that name. Python exports it there.
inline Module public_in(py::module_& module, const char* name) {
  module.attr("__module__") = name;
  return Module(module);
}

}  // namespace robsim::bindings
