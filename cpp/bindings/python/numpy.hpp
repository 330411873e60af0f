// All conversion between Python values and those of the core, with checks of type and shape.
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

#include "robsim/base/geometry.hpp"
#include "robsim/imaging/image.hpp"
#include "robsim/model/robot_model.hpp"
#include "robsim/vision/locate.hpp"

namespace robsim::bindings {

namespace py = pybind11;

// Types in help and in the stub for arguments of more than one type. They accept any value, because
// the conversions raise the errors.
inline bool is_anything(PyObject* value) { return value != nullptr; }

/// What numpy makes an array of: a pose, points, inputs, a matrix.
class ArrayLike : public py::object {
 public:
  PYBIND11_OBJECT_DEFAULT(ArrayLike, py::object, is_anything)
};

/// The pixels of an image.
class PixelArray : public py::object {
 public:
  PYBIND11_OBJECT_DEFAULT(PixelArray, py::object, is_anything)
};

/// A Frame or the pixels of an image.
class ImageLike : public py::object {
 public:
  PYBIND11_OBJECT_DEFAULT(ImageLike, py::object, is_anything)
};

/// A Measurement or its pose.
class MeasurementLike : public py::object {
 public:
  PYBIND11_OBJECT_DEFAULT(MeasurementLike, py::object, is_anything)
};

/// A box of pixels: left, top, right, bottom.
class Region : public py::object {
 public:
  PYBIND11_OBJECT_DEFAULT(Region, py::object, is_anything)
};

}  // namespace robsim::bindings

template <>
struct pybind11::detail::handle_type_name<robsim::bindings::ArrayLike> {
  static constexpr auto name = const_name("numpy.typing.ArrayLike");
};
template <>
struct pybind11::detail::handle_type_name<robsim::bindings::PixelArray> {
  static constexpr auto name = const_name("numpy.typing.NDArray[numpy.uint8]");
};
template <>
struct pybind11::detail::handle_type_name<robsim::bindings::ImageLike> {
  static constexpr auto name = const_name("robsim.Frame | numpy.typing.NDArray[numpy.uint8]");
};
template <>
struct pybind11::detail::handle_type_name<robsim::bindings::MeasurementLike> {
  static constexpr auto name = const_name("robsim.Measurement | numpy.typing.ArrayLike");
};
template <>
struct pybind11::detail::handle_type_name<robsim::bindings::Region> {
  static constexpr auto name = const_name("collections.abc.Sequence[int]");
};

namespace robsim::bindings {

using Shape = std::vector<py::ssize_t>;
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// A shape as Python prints it: "(3,)", "(3, 5)".
std::string shape_text(const py::ssize_t* sizes, py::ssize_t dimensions);

/// The value that came, for an error message: "None", "array of shape (2,)", "'red'", ...
std::string describe(py::handle value);

/// As `doubles_from`, but NaN and infinity are accepted.
Doubles numbers_from(py::handle value, const std::string& name, const std::optional<Shape>& shape,
                     const std::string& expected);

/// An array of finite float64 numbers of this shape (-1 = any size; none = any shape).
/// Throws py::type_error or py::value_error that names the argument and what was expected.
Doubles doubles_from(py::handle value, const std::string& name, const std::optional<Shape>& shape,
                     const std::string& expected);

/// The function of a number for a number, an array of them for an array.
py::object for_each_number(py::handle value, const std::string& name, const std::string& expected,
                           double (*function)(double));

Pose pose_from(py::handle value, const std::string& name);
Point point_from(py::handle value, const std::string& name);
Input input_from(py::handle value, const std::string& name);
Polygon polygon_from(py::handle value, const std::string& name);
AxisMatrix axis_matrix_from(py::handle value, const std::string& name);

/// Throws ValueError for variances below 0.
PoseCovariance covariance_from(py::handle value, const std::string& name);

/// That of a pose of which nothing more is known.
Measurement measurement_of(const Pose& pose);

/// A Measurement, or one of this pose.
Measurement measurement_from(py::handle value, const std::string& name);

/// Throws py::value_error unless it is the number of a step.
inline void check_step_number(std::int64_t k) {
  if (k < 0) throw py::value_error("k must be at least 0, got " + std::to_string(k));
}

/// A read-only copy.
py::array_t<double> to_array(const double* values, const Shape& shape);
py::array_t<double> to_array(const Pose& pose);
py::array_t<double> to_array(const Point& point);
py::array_t<double> to_array(const Input& u);

template <typename Derived>
py::array_t<double> to_array(const Eigen::MatrixBase<Derived>& matrix) {
  const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> rows = matrix;
  if (Derived::IsVectorAtCompileTime) return to_array(rows.data(), Shape{rows.size()});
  return to_array(rows.data(), Shape{rows.rows(), rows.cols()});
}

template <typename T>
std::optional<py::array_t<double>> to_array(const std::optional<T>& value) {
  return value ? std::optional(to_array(*value)) : std::nullopt;
}

/// A view of the caller's uint8 RGB pixels, shape (H, W, 3), rows of any stride. Copies nothing.
ImageView image_view(py::handle value, const std::string& name);

/// An image on the memory of an array as `image_view` has them, or of any buffer of that type and
/// shape: read-only, and keeps it alive. Copies nothing.
Image borrowed_image(py::handle value, const std::string& name);

/// The same, but writable.
Image writable_image(py::handle value, const std::string& name);

/// The pixels of a Frame, or those of an array as `image_view` has them.
ImageView view_from(py::handle value, const std::string& name);

/// The box of (left, top, right, bottom), all four included.
PixelBox region_from(py::handle value, const std::string& name);

/// As `image_view`, but writable; rows must not overlap.
WritableView writable_view(py::handle value, const std::string& name);

/// A read-only view of shape (H, W, 3) that keeps the image's pixels alive.
py::array_t<std::uint8_t> image_array(const Image& image);

/// The value of a named choice. Throws py::value_error that lists the names.
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

/// The name of a colour, checked. `what` it is called in the message.
inline std::string name_from(const pybind11::str& name, const char* what = "name") {
  return py::module_::import("robsim.base.checks")
      .attr("check_words")(what, name)
      .cast<std::string>();
}

}  // namespace robsim::bindings
