#include "python/signature.hpp"
#include "robsim/base/elementary/elementary.hpp"
#include "robsim/base/geometry.hpp"
#include "robsim/base/simd/cpu_path.hpp"

using namespace robsim;
using namespace robsim::bindings;
using namespace robsim::simd;

namespace {

// A function of a number, which takes arrays, too.
void bind_function(Module module, const char* name, double (*function)(double),
                   const char* argument, const std::string& unit, const char* doc) {
  const auto call = [=](const ArrayLike& value) {
    return for_each_number(value, argument, "a number or an array of numbers" + unit, function);
  };
  module.def(name, call, py::arg(argument), doc);
}

void bind_simd(py::module_& module) {
  public_in(module, "robsim._core")
      .def(
          "cpu_path", [] { return std::string(name_of(cpu_path())); },
          "Return the instruction set of the hot loops: \"baseline\", \"avx2\" or \"avx512\".")
      .def(
          "cpu_paths",
          [] {
            std::vector<std::string> names;
            for (const CpuPath path : cpu_paths()) names.emplace_back(name_of(path));
            return names;
          },
          "Return the paths available on this processor, the fastest last.")
      .def(
          "force_cpu_path",
          [](const std::string& name) {
            for (const CpuPath path : cpu_paths()) {
              if (name == name_of(path)) return force_cpu_path(path);
            }
            throw std::invalid_argument("path must be one that this processor has, got '" + name +
                                        "'");
          },
          "path"_a, R"(
Use other instructions from now on. The results are identical, bit for bit.

Parameters
----------
path : str
    One of `cpu_paths`.

Raises
------
ValueError
    If the path is not available on this processor.
)");
}

// Functions for excitations and worlds in Python: the same bits on every machine, where the
// functions of math and numpy differ in the last digit.
void bind_elementary(py::module_& module) {
  const auto bind = [&](const char* name, double (*function)(double), const char* doc) {
    bind_function(public_in(module, "robsim._core"), name, function, "x", "", doc);
  };
  bind("sin", &elementary::sin, "Return the sine of an angle (rad), or of each in an array.");
  bind("cos", &elementary::cos, "Return the cosine of an angle (rad), or of each in an array.");
  bind("exp", &elementary::exp, "Return e to the power of a number, or of each in an array.");
  bind("log", &elementary::log,
       "Return the natural logarithm of a number, or of each in an array.");
  public_in(module, "robsim._core")
      .def("atan2", &elementary::atan2, "y"_a, "x"_a,
           "Return the angle of the point (x, y) from the x axis (rad), in [-pi, pi].")
      .def("hypot", &elementary::hypot, "x"_a, "y"_a, "Return the length of the vector (x, y).")
      .def("random_uniform", &random_uniform, "seed"_a, "counter"_a,
           "Return the number in [0, 1) at a place in the stream of a seed.")
      .def("random_normal", &random_normal, "seed"_a, "counter"_a,
           "Return the standard normal number at a place in the stream of a seed.");
}

}  // namespace

void bind_base(py::module_& module) {
  bind_simd(module);
  bind_elementary(module);
  bind_function(public_in(module, "robsim"), "wrap_angle", &robsim::wrap_angle, "angle", " (rad)",
                R"(
Return the angle in (-pi, pi], equal up to full turns.

Parameters
----------
angle : float or array
    Angle (rad).

Returns
-------
float or array
    Wrapped angle (rad), of the same shape.

Examples
--------
>>> robsim.wrap_angle(np.radians([190, -190])).round(3)
array([-2.967,  2.967])
)");
}
