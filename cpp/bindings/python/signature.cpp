#include "python/signature.hpp"

#include <string.h>  // strdup

#include <algorithm>
#include <array>
#include <cstdlib>
#include <stdexcept>
#include <unordered_map>

#include "python/numpy.hpp"

namespace robsim::bindings {

namespace {

// The parameters of a function without `self`.
struct Signature {
  std::string name;  // as users call it: "find_blobs", "Frame", "predict"
  bool has_self = false;
  std::vector<Parameter> parameters;
};

// The functions with signatures, by what Python hands to them as `self`.
std::unordered_map<PyObject*, Signature>& signatures() {
  static auto* all = new std::unordered_map<PyObject*, Signature>;  // outlives the interpreter
  return *all;
}

// What stands in a signature for a default; `...` for what is not written as a literal.
std::string default_text(const py::object& value) {
  const auto text = py::repr(value).cast<std::string>();
  return std::string("<ABCDEGHIJKLMOPQRSUVWXYZ").find(text.front()) == std::string::npos ? text
                                                                                         : "...";
}

// "(image, *, copy=True, t=None)".
std::string text_of(const Signature& signature) {
  std::string text = signature.has_self ? "self" : "";
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

std::string names_of(const std::vector<Parameter>& parameters) {
  std::string names;
  for (const Parameter& parameter : parameters) {
    names += (names.empty() ? "" : ", ") + parameter.name;
  }
  return names;
}

std::string suggestion(const std::string& name, const std::vector<Parameter>& parameters) {
  py::list known;
  for (const Parameter& parameter : parameters) known.append(parameter.name);
  return py::module_::import("robsim.base.spelling")
      .attr("suggestion")(name, known)
      .cast<std::string>();
}

// The arguments of a call that has failed.
class Call {
 public:
  Call(const Signature& signature, PyObject* const* arguments, Py_ssize_t n_positional,
       PyObject* keywords)
      : signature_(signature), arguments_(arguments), keywords_(keywords) {
    n_positional_ = static_cast<std::size_t>(n_positional) - (signature.has_self ? 1 : 0);
    first_ = signature.has_self ? 1 : 0;
    given_.resize(signature.parameters.size());
  }

  // What is wrong with the arguments; "" if they are right.
  std::string complaint() {
    std::string text = take_positional();
    if (text.empty()) text = take_keywords();
    if (text.empty()) text = missing();
    return text.empty() ? wrong_type() : text;
  }

 private:
  std::string take_positional() {
    std::size_t allowed = 0;
    for (const Parameter& parameter : signature_.parameters) allowed += !parameter.is_keyword_only;
    if (n_positional_ > allowed) {
      const bool more = allowed < signature_.parameters.size();
      return signature_.name + "() takes " + (allowed ? std::to_string(allowed) : "no") +
             " positional argument" + (allowed == 1 ? "" : "s") + ", got " +
             std::to_string(n_positional_) + (more ? ": give the others by name, as in " : "") +
             (more ? signature_.parameters[allowed].name + "=..." : "");
    }
    for (std::size_t i = 0; i < n_positional_; ++i) given_[i] = arguments_[first_ + i];
    return "";
  }

  std::string take_keywords() {
    const Py_ssize_t count = keywords_ ? PyTuple_GET_SIZE(keywords_) : 0;
    for (Py_ssize_t i = 0; i < count; ++i) {
      const auto name = py::handle(PyTuple_GET_ITEM(keywords_, i)).cast<std::string>();
      const std::size_t at = index_of(name);
      if (at == given_.size()) return unexpected(name);
      if (given_[at]) return signature_.name + "() got two values for " + name;
      given_[at] = arguments_[first_ + n_positional_ + static_cast<std::size_t>(i)];
    }
    return "";
  }

  std::size_t index_of(const std::string& name) const {
    std::size_t i = 0;
    while (i < given_.size() && signature_.parameters[i].name != name) ++i;
    return i;
  }

  std::string unexpected(const std::string& name) const {
    const std::string text = signature_.name + "() has no argument '" + name + "'";
    if (signature_.parameters.empty()) return text + ": it takes none";
    const std::string meant = suggestion(name, open_parameters());
    return text + (meant.empty() ? ": it takes " + names_of(signature_.parameters) : meant);
  }

  // Those that no value has come for.
  std::vector<Parameter> open_parameters() const {
    std::vector<Parameter> open;
    for (std::size_t i = 0; i < given_.size(); ++i) {
      if (!given_[i]) open.push_back(signature_.parameters[i]);
    }
    return open;
  }

  std::string missing() const {
    for (std::size_t i = 0; i < given_.size(); ++i) {
      const Parameter& parameter = signature_.parameters[i];
      if (!given_[i] && !parameter.default_value) {
        return signature_.name + "() needs the argument " + parameter.name;
      }
    }
    return "";
  }

  std::string wrong_type() const {
    for (std::size_t i = 0; i < given_.size(); ++i) {
      const Parameter& parameter = signature_.parameters[i];
      if (given_[i] && !parameter.accepts(given_[i])) {
        return parameter.name + " must be " + parameter.expected(given_[i]) + ", got " +
               describe(given_[i]);
      }
    }
    return "";
  }

  const Signature& signature_;
  PyObject* const* arguments_;
  PyObject* keywords_;
  std::size_t n_positional_;
  std::size_t first_;  // after self
  std::vector<py::handle> given_;
};

using FastCall = PyObject* (*)(PyObject*, PyObject* const*, Py_ssize_t, PyObject*);

FastCall dispatcher = nullptr;  // pybind11's, the same for all functions

// Values that pybind11 takes for what they are not.
bool has_odd_value(PyObject* const* arguments, Py_ssize_t n_positional, PyObject* keywords) {
  const Py_ssize_t count = n_positional + (keywords ? PyTuple_GET_SIZE(keywords) : 0);
  return std::any_of(arguments, arguments + count, [](PyObject* value) {
    return value == Py_None || PyBool_Check(value) || PyBytes_Check(value);
  });
}

// What is wrong with the arguments of a call; "" if they are right, or cannot be shown.
std::string complaint_of(PyObject* self, PyObject* const* arguments, Py_ssize_t n_positional,
                         PyObject* keywords) {
  const Signature& signature = signatures().at(self);
  if (signature.has_self && n_positional == 0) {
    return signature.name + "() is a method: it needs an object";
  }
  try {
    const py::error_scope kept;
    return Call(signature, arguments, n_positional, keywords).complaint();
  } catch (const std::exception&) {
    return "";
  }
}

// Calls a function; where the arguments are wrong, the error is ours.
PyObject* call(PyObject* self, PyObject* const* arguments, Py_ssize_t n_positional,
               PyObject* keywords) {
  PyObject* result = nullptr;
  std::string text;
  if (has_odd_value(arguments, n_positional, keywords)) {
    text = complaint_of(self, arguments, n_positional, keywords);
  }
  if (text.empty()) {
    result = dispatcher(self, arguments, n_positional, keywords);
    if (result || !PyErr_ExceptionMatches(PyExc_TypeError)) return result;
    text = complaint_of(self, arguments, n_positional, keywords);
  }
  if (!text.empty()) PyErr_SetString(PyExc_TypeError, text.c_str());
  return nullptr;
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

// Functions that belong to a module or class in the eyes of Python. What pybind11 needs as `self`
// is kept here, and each has an entry of its own that knows its place.
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

void ParameterList::set_types(std::initializer_list<Type> types) {
  auto type = std::rbegin(types);  // backwards: those of `self` and such come first
  for (auto parameter = list_.rbegin(); parameter != list_.rend(); ++parameter, ++type) {
    if (type == std::rend(types)) return;
    parameter->accepts = type->accepts;
    parameter->expected = type->expected;
  }
}

void sign_function(py::handle owner, const char* name, const ParameterList& parameters) {
  const py::object function = owner.attr(name);
  give_signature(function, {name, false, parameters.get()});
  give_owner(function, owner);
}

void sign_method(py::handle owner, const char* name, const ParameterList& parameters) {
  const std::string method = name;
  const bool is_init = method == "__init__";
  if (!is_init && method != "__call__" && method.substr(0, 2) == "__") return;
  const auto shown = is_init ? owner.attr("__name__").cast<std::string>() : method;
  give_signature(owner.attr(name), {shown, true, parameters.get()});
}

}  // namespace robsim::bindings
