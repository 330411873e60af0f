#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "python/numpy.hpp"
#include "python/signature.hpp"
#include "robsim/base/elementary/elementary.hpp"
#include "robsim/base/geometry.hpp"
#include "robsim/base/simd/cpu_path.hpp"

namespace py = pybind11;
using namespace robsim;
using namespace robsim::bindings;
using namespace robsim::simd;

void bind_simd(py::module_& module) {
  public_in(module, "robsim._core")
      .def(
          "cpu_path", [] { return std::string(name_of(cpu_path())); },
          "Return which instructions the hot loops use: \"baseline\", \"avx2\" or \"avx512\".");
  public_in(module, "robsim._core")
      .def(
          "cpu_paths",
          [] {
            std::vector<std::string> names;
            for (const CpuPath path : cpu_paths()) names.emplace_back(name_of(path));
            return names;
          },
          "Return the paths available on this processor, the fastest last.");
  public_in(module, "robsim._core")
      .def(
          "force_cpu_path",
          [](const std::string& name) {
            for (const CpuPath path : cpu_paths()) {
              if (name == name_of(path)) {
                force_cpu_path(path);
                return;
              }
            }
            throw std::invalid_argument("path must be one that this processor has, got '" + name +
                                        "'");
          },
          py::arg("path"), R"(
Use other instructions from now on. The results are identical, bit for bit.

Parameters
----------
path : str
    One of `cpu_paths`.

Raises
------
ValueError
    If it is not available on this processor.
)");
}

// What excitations and worlds are computed with in Python: the same bits on every machine, where
// the functions of math and numpy differ in the last digit.
void bind_elementary(py::module_& module) {
  const auto bind = [&](const char* name, double (*function)(double), const char* documentation) {
    public_in(module, "robsim._core")
        .def(
            name,
            [function](const ArrayLike& x) {
              return for_each_number(x, "x", "a number or an array of numbers", function);
            },
            py::arg("x"), documentation);
  };
  bind("sin", &elementary::sin, "Return the sine of an angle (rad), or of each in an array.");
  bind("cos", &elementary::cos, "Return the cosine of an angle (rad), or of each in an array.");
  bind("exp", &elementary::exp, "Return e to the power of a number, or of each in an array.");
  bind("log", &elementary::log,
       "Return the natural logarithm of a number, or of each in an array.");
  public_in(module, "robsim._core")
      .def("atan2", &elementary::atan2, py::arg("y"), py::arg("x"),
           "Return the angle of the point (x, y) from the x axis (rad), in [-pi, pi].");
  public_in(module, "robsim._core")
      .def("hypot", &elementary::hypot, py::arg("x"), py::arg("y"),
           "Return the length of the vector (x, y).");
  public_in(module, "robsim._core")
      .def("random_uniform", &random_uniform, py::arg("seed"), py::arg("counter"),
           "Return the number in [0, 1) at a place of the stream of a seed.");
  public_in(module, "robsim._core")
      .def("random_normal", &random_normal, py::arg("seed"), py::arg("counter"),
           "Return the standard normal number at a place of the stream of a seed.");
}

namespace {

// A number for a number, an array for an array.
py::object wrapped(const ArrayLike& angle) {
  return for_each_number(angle, "angle", "a number or an array of numbers (rad)",
                         &robsim::wrap_angle);
}

}  // namespace

void bind_geometry(py::module_& module) {
  public_in(module, "robsim").def("wrap_angle", &wrapped, py::arg("angle"), R"(
Return the angle in (-pi, pi] that differs by full turns.

Parameters
----------
angle : float or array
    Angle (rad).

Returns
-------
float or array
    Wrapped angle (rad), of the same shape.
)");
}
