#include "python/numpy.hpp"
#include "python/public_names.hpp"
#include "robsim/base/geometry.hpp"

namespace py = pybind11;
using namespace robsim::bindings;

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
