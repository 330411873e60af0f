#include <algorithm>

#include "python/numpy.hpp"
#include "python/public_names.hpp"
#include "robsim/geometry/pose.hpp"

namespace py = pybind11;
using namespace robsim::bindings;

namespace {

// A number for a number, an array for an array.
py::object wrapped(const ArrayLike& angle) {
  if (PyFloat_Check(angle.ptr())) return py::float_(robsim::wrap_angle(angle.cast<double>()));
  const std::string expected = "a number or an array of numbers (rad)";
  const Doubles angles = numbers_from(angle, "angle", std::nullopt, expected);
  py::array_t<double> result(Shape(angles.shape(), angles.shape() + angles.ndim()));
  std::transform(angles.data(), angles.data() + angles.size(), result.mutable_data(),
                 &robsim::wrap_angle);
  if (result.ndim() == 0) return py::float_(*result.data());
  return std::move(result);
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
