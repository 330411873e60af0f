// Signatures of native functions: for inspect and help, and for errors that name the argument.
#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "python/expected.hpp"

namespace robsim::bindings {

/// A parameter as a caller sees it.
struct Parameter {
  std::string name;
  bool is_keyword_only = false;
  py::object default_value;  // null: there is none
  bool (*accepts)(py::handle) = nullptr;
  std::string (*expected)(py::handle) = nullptr;
};

/// The parameters of a function without `self`.
struct Signature {
  std::string name;  // as users call it: "find_blobs", "Frame", "predict"
  bool has_self = false;
  std::vector<Parameter> parameters;
};

/// Lets `inspect.signature` know a native function, and a call with wrong arguments raise a
/// TypeError that names the argument, what was expected and what came.
void give_signature(const py::object& function, const Signature& signature);

/// Lets a native function with a signature belong to a module or class, as those of Python do: help
/// would say that it is a method of something of pybind11, and it could not be pickled.
void give_owner(const py::object& function, py::handle owner);

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

/// Collects what pybind11 is told of the arguments of a function.
class ParameterList {
 public:
  void add(const py::arg& argument) { list_.push_back({argument.name, is_keyword_only_, {}}); }
  void add(const py::arg_v& argument) {
    list_.push_back({argument.name, is_keyword_only_, argument.value});
  }
  void add(const py::kw_only&) { is_keyword_only_ = true; }
  template <typename Other>
  void add(const Other&) {}

  /// The list, with the types T of all arguments; those of `self` and such come first.
  template <typename... T>
  std::vector<Parameter> with_types(const std::tuple<T...>*) && {
    std::size_t i = list_.size() - sizeof...(T);  // wraps, and comes to 0 at the first in the list
    (set_type<T>(i++), ...);
    return std::move(list_);
  }

 private:
  template <typename T>
  void set_type(std::size_t i) {
    if constexpr (!std::is_same_v<T, py::detail::value_and_holder>) {
      if (i >= list_.size()) return;
      list_[i].accepts = &accepts<T>;
      list_[i].expected = &Expected<T>::text;
    }
  }

  std::vector<Parameter> list_;
  bool is_keyword_only_ = false;
};

template <typename F, typename... Extra>
Signature signature_of(const std::string& name, bool has_self, const Extra&... extra) {
  ParameterList parameters;
  (parameters.add(extra), ...);
  using Types = typename ArgumentTypes<std::decay_t<F>>::type;
  return {name, has_self, std::move(parameters).with_types(static_cast<const Types*>(nullptr))};
}

/// As py::module_, for functions with signatures.
class Module : public py::module_ {
 public:
  explicit Module(const py::module_& module) : py::module_(module) {}

  template <typename F, typename... Extra>
  Module& def(const char* name, F&& f, const Extra&... extra) {
    py::module_::def(name, std::forward<F>(f), extra...);
    give_signature(attr(name), signature_of<F>(name, false, extra...));
    give_owner(attr(name), *this);
    return *this;
  }
};

/// As py::class_, for methods with signatures.
template <typename T, typename... Options>
class Class : public py::class_<T, Options...> {
  using Base = py::class_<T, Options...>;

 public:
  using Base::Base;

  template <typename F, typename... Extra>
  Class& def(const char* name, F&& f, const Extra&... extra) {
    Base::def(name, std::forward<F>(f), extra...);
    const std::string method = name;
    if (method == "__init__" || method == "__call__" || method.substr(0, 2) != "__") {
      const auto type = this->attr("__name__").template cast<std::string>();
      const std::string shown = method == "__init__" ? type : method;
      give_signature(this->attr(name), signature_of<F>(shown, true, extra...));
    }
    return *this;
  }

  template <typename... Args, typename... Extra>
  Class& def(const py::detail::initimpl::constructor<Args...>& init, const Extra&... extra) {
    init.execute(*this, extra...);
    return *this;
  }
  template <typename... Args, typename... Extra>
  Class& def(py::detail::initimpl::factory<Args...>&& init, const Extra&... extra) {
    std::move(init).execute(*this, extra...);
    return *this;
  }
  template <typename... Args, typename... Extra>
  Class& def(py::detail::initimpl::pickle_factory<Args...>&& pickle, const Extra&... extra) {
    std::move(pickle).execute(*this, extra...);
    return *this;
  }

  template <typename F, typename... Extra>
  Class& def_static(const char* name, F&& f, const Extra&... extra) {
    Base::def_static(name, std::forward<F>(f), extra...);
    give_signature(this->attr(name), signature_of<F>(name, false, extra...));
    give_owner(this->attr(name), *this);
    return *this;
  }

  template <typename... Rest>
  Class& def_readonly(const char* name, const Rest&... rest) {
    Base::def_readonly(name, rest...);
    return *this;
  }
  template <typename Get, typename... Rest>
  Class& def_property_readonly(const char* name, const Get& get, const Rest&... rest) {
    Base::def_property_readonly(name, get, rest...);
    return *this;
  }
};

}  // namespace robsim::bindings
