// All conversion between Python values and the core's, with the checks of type and shape.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/typing.h>

#include <array>
#include <initializer_list>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "robsim/geometry/polygon.hpp"
#include "robsim/imaging/image.hpp"
#include "robsim/model/robot_model.hpp"

namespace robsim::bindings {

namespace py = pybind11;

using Shape = std::vector<py::ssize_t>;
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// What came instead, for an error message: "None", "array of shape (2,)", "'red'", ...
std::string describe(py::handle value);

/// An array of float64 numbers of this shape, NaN and infinity among them; else as `doubles_from`.
Doubles numbers_from(py::handle value, const std::string& name, const std::optional<Shape>& shape,
                     const std::string& expected);

/// An array of finite float64 numbers of this shape (-1 = any size; none = any shape).
/// Throws py::type_error or py::value_error that names the value and what was expected.
Doubles doubles_from(py::handle value, const std::string& name, const std::optional<Shape>& shape,
                     const std::string& expected);

Pose pose_from(py::handle value, const std::string& name);
Point point_from(py::handle value, const std::string& name);
Input input_from(py::handle value, const std::string& name);
Polygon polygon_from(py::handle value, const std::string& name);
AxisMatrix axis_matrix_from(py::handle value, const std::string& name);

/// A read-only array of its own memory.
py::array_t<double> to_array(const double* values, const Shape& shape);
py::array_t<double> to_array(const Pose& pose);
py::array_t<double> to_array(const Point& point);
py::array_t<double> to_array(const AxisMatrix& matrix);

/// The caller's uint8 RGB pixels, shape (H, W, 3), rows of any stride, without a copy.
ImageView image_view(py::handle value, const std::string& name);

/// The caller's pixels, to be written: as image_view, rows one after the other.
WritableView writable_view(py::handle value, const std::string& name);

/// A read-only view of shape (H, W, 3) that keeps the image's buffer alive.
py::array_t<std::uint8_t> image_array(const Image& image);

/// The value that belongs to a name. Throws py::value_error that lists the names.
template <typename T>
T choice_from(const std::string& name, const std::string& chosen,
              std::initializer_list<std::pair<const char*, T>> choices) {
  std::string names;
  for (const auto& [key, value] : choices) {
    if (chosen == key) return value;
    names += (names.empty() ? "'" : ", '") + std::string(key) + "'";
  }
  throw py::value_error(name + " must be one of " + names + ", got '" + chosen + "'");
}

}  // namespace robsim::bindings
