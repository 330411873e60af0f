#include "python/numpy.hpp"
#include "python/public_names.hpp"
#include "robsim/base/elementary/elementary.hpp"

namespace py = pybind11;
using namespace robsim;
using namespace robsim::bindings;

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
