#include "python/numpy.hpp"
#include "python/public_names.hpp"
#include "robsim/geometry/pose.hpp"

namespace py = pybind11;
using robsim::bindings::public_in;

void bind_geometry(py::module_& module) {
  public_in(module, "robsim")
      .def("wrap_angle", py::vectorize(&robsim::wrap_angle), py::arg("angle"), R"(
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
