#include "numpy.hpp"
#include "robsim/geometry/pose.hpp"

namespace py = pybind11;

void bind_geometry(py::module_& module) {
  module.def("wrap_angle", py::vectorize(&robsim::wrap_angle), py::arg("angle"), R"(
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
