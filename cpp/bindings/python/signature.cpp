#include "python/signature.hpp"

#include <string.h>  // strdup

#include <algorithm>
#include <cstdlib>
#include <unordered_map>

namespace robsim::bindings {

namespace {

// The parameters of a function without `self`.
struct Signature {
  std::string name;  // as users call it: "find_blobs", "Frame", "predict"
  py::handle owner;  // of a method, whose first argument is an object of this class
  std::vector<Parameter> parameters;
};

// The functions with signatures, by what Python hands to them as `self`.
std::unordered_map<PyObject*, Signature>& signatures() {
  static auto* all = new std::unordered_map<PyObject*, Signature>;  // outlives the interpreter
  return *all;
}

// The text of a default in a signature; `...` for a value that has no literal.
std::string default_text(const py::object& value) {
  const auto text = py::repr(value).cast<std::string>();
  return std::string("<ABCDEGHIJKLMOPQRSUVWXYZ").find(text.front()) == std::string::npos ? text
                                                                                         : "...";
}

// "(image, *, copy=True, t=None)".
std::string text_of(const Signature& signature) {
  std::string text = signature.owner ? "self" : "";
  bool is_keyword_only = false;
  for (const Parameter& parameter : signature.parameters) {
    text += text.empty() ? "" : ", ";
    if (parameter.is_keyword_only && !is_keyword_only) text += "*, ";
    is_keyword_only = parameter.is_keyword_only;
    text += parameter.name;
    if (parameter.default_value) text += "=" + default_text(parameter.default_value);
  }
  return "(" + text + ")";
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
    text.replace(at, from.size(), to);
  }
  return text;
}

// The doc of a function with its types as people write them.
std::string readable(const char* doc) {
  std::string text = doc ? doc : "";
  text = replaced(text, "typing.SupportsFloat | typing.SupportsIndex", "float");
  return replaced(text, "typing.SupportsInt | typing.SupportsIndex", "int");
}

// How Python's C functions carry their signature: before the doc, which does not show it.
std::string with_signature(const PyMethodDef& method, const Signature& signature) {
  return method.ml_name + text_of(signature) + "\n--\n\n" + readable(method.ml_doc);
}

using FastCall = PyObject* (*)(PyObject*, PyObject* const*, Py_ssize_t, PyObject*);

FastCall dispatcher = nullptr;  // pybind11's, the same for all functions

// Values that pybind11 takes for other types.
bool has_odd_value(PyObject* const* arguments, Py_ssize_t n_positional, PyObject* keywords) {
  const Py_ssize_t count = n_positional + (keywords ? PyTuple_GET_SIZE(keywords) : 0);
  return std::any_of(arguments, arguments + count, [](PyObject* value) {
    return value == Py_None || PyBool_Check(value) || PyBytes_Check(value);
  });
}

// Throws an error for an argument of a wrong type.
void check_types(const Signature& signature, PyObject* const* arguments, Py_ssize_t n_positional,
                 PyObject* keywords) {
  Py_ssize_t i = signature.owner ? 1 : 0;
  for (const Parameter& parameter : signature.parameters) {
    if (i == n_positional) break;
    parameter.check(arguments[i++], parameter.name);
  }
  for (i = 0; keywords && i < PyTuple_GET_SIZE(keywords); ++i) {
    const auto name = py::handle(PyTuple_GET_ITEM(keywords, i)).cast<std::string>();
    for (const Parameter& parameter : signature.parameters) {
      if (parameter.name == name) parameter.check(arguments[n_positional + i], name);
    }
  }
}

// Throws an error for arguments that are missing, too many, or of no name: base/spelling.py.
void check_names(const Signature& signature, Py_ssize_t n_positional, PyObject* keywords) {
  py::list names, required;
  const auto given = keywords ? py::reinterpret_borrow<py::tuple>(keywords) : py::tuple();
  int n_allowed = 0;
  for (const Parameter& parameter : signature.parameters) {
    names.append(parameter.name);
    if (!parameter.default_value) required.append(parameter.name);
    n_allowed += !parameter.is_keyword_only;
  }
  py::module_::import("robsim.base.spelling")
      .attr("check_call")(signature.name, names, required, n_allowed,
                          n_positional - (signature.owner ? 1 : 0), given);
}

// Raises the error of wrong arguments of a call. If they are right, or the error cannot be shown,
// it returns false, and an earlier error stays.
bool complain(PyObject* self, PyObject* const* arguments, Py_ssize_t n_positional,
              PyObject* keywords, bool are_names_right) {
  const Signature& signature = signatures().at(self);
  std::optional<py::error_already_set> before;
  if (PyErr_Occurred()) before.emplace();
  try {
    if (signature.owner && (n_positional == 0 || !py::isinstance(arguments[0], signature.owner))) {
      const auto owner = signature.owner.attr("__name__").cast<std::string>();
      throw py::type_error(signature.name + "() is a method: it needs an object of " + owner);
    }
    if (!are_names_right) check_names(signature, n_positional, keywords);
    check_types(signature, arguments, n_positional, keywords);
  } catch (const py::builtin_exception& error) {
    error.set_error();
    return true;
  } catch (const std::invalid_argument& error) {
    PyErr_SetString(PyExc_ValueError, error.what());
    return true;
  } catch (py::error_already_set& error) {
    if (error.matches(PyExc_TypeError)) {
      error.restore();
      return true;
    }
  } catch (const std::exception&) {
  }
  if (before) before->restore();
  return false;
}

// Calls a function; where the arguments are wrong, the error is ours.
PyObject* call(PyObject* self, PyObject* const* arguments, Py_ssize_t n_positional,
               PyObject* keywords) {
  if (has_odd_value(arguments, n_positional, keywords) &&
      complain(self, arguments, n_positional, keywords, true)) {
    return nullptr;
  }
  PyObject* const result = dispatcher(self, arguments, n_positional, keywords);
  if (!result && PyErr_ExceptionMatches(PyExc_TypeError)) {
    complain(self, arguments, n_positional, keywords, false);
  }
  return result;
}

PyCFunction as_c_function(FastCall function) {
  return reinterpret_cast<PyCFunction>(reinterpret_cast<void (*)()>(function));
}

PyCFunctionObject& c_function(const py::object& function) {
  PyObject* const plain = PyInstanceMethod_Check(function.ptr())
                              ? PyInstanceMethod_GET_FUNCTION(function.ptr())
                              : function.ptr();
  return *reinterpret_cast<PyCFunctionObject*>(plain);
}

// Functions that belong to a module or class in the eyes of Python. Their `self` for pybind11 is
// kept here, and each has a separate entry that knows its place.
constexpr std::size_t maximum_functions = 64;
std::array<PyObject*, maximum_functions> records{};
std::size_t n_functions = 0;

template <std::size_t place>
PyObject* enter(PyObject*, PyObject* const* arguments, Py_ssize_t n_positional,
                PyObject* keywords) {
  return call(records[place], arguments, n_positional, keywords);
}

template <std::size_t... places>
constexpr std::array<FastCall, sizeof...(places)> entries(std::index_sequence<places...>) {
  return {&enter<places>...};
}

void give_signature(const py::object& function, const Signature& signature) {
  PyCFunctionObject* const object = &c_function(function);
  PyMethodDef& method = *object->m_ml;
  const std::string doc = with_signature(method, signature);
  std::free(const_cast<char*>(method.ml_doc));
  method.ml_doc = strdup(doc.c_str());
  // Should pybind11 call in another way one day, its own errors stay.
  if (method.ml_flags != (METH_FASTCALL | METH_KEYWORDS)) return;
  const auto original = reinterpret_cast<FastCall>(reinterpret_cast<void (*)()>(method.ml_meth));
  if (!dispatcher) dispatcher = original;
  method.ml_meth = as_c_function(&call);
  signatures().emplace(object->m_self, signature);
}

void give_owner(const py::object& function, py::handle owner) {
  static constexpr auto all = entries(std::make_index_sequence<maximum_functions>());
  PyCFunctionObject& object = c_function(function);
  if (object.m_ml->ml_meth != as_c_function(&call)) return;
  if (n_functions == all.size()) throw std::logic_error("more functions than maximum_functions");
  records[n_functions] = object.m_self;  // kept for good
  object.m_self = owner.inc_ref().ptr();
  object.m_ml->ml_meth = as_c_function(all[n_functions++]);
}

}  // namespace

void ParameterList::add(const py::arg& argument) {
  list_.push_back({argument.name, is_keyword_only_, {}});
}

void ParameterList::add(const py::arg_v& argument) {
  list_.push_back({argument.name, is_keyword_only_, argument.value});
}

void ParameterList::set_checks(std::initializer_list<Check> checks) {
  auto check = std::rbegin(checks);  // backwards: those of `self` and such come first
  for (auto parameter = list_.rbegin(); parameter != list_.rend(); ++parameter, ++check) {
    if (check == std::rend(checks)) return;
    parameter->check = *check;
  }
}

void sign_function(py::handle owner, const char* name, const ParameterList& parameters) {
  const py::object function = owner.attr(name);
  give_signature(function, {name, {}, parameters.get()});
  give_owner(function, owner);
}

void sign_method(py::handle owner, const char* name, const ParameterList& parameters) {
  const std::string method = name;
  const bool is_init = method == "__init__";
  if (!is_init && method != "__call__" && method.substr(0, 2) == "__") return;
  const auto shown = is_init ? owner.attr("__name__").cast<std::string>() : method;
  give_signature(owner.attr(name), {shown, owner, parameters.get()});
}

}  // namespace robsim::bindings
