// All conversion between Python values and C++ values, with checks of type and shape.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/typing.h>

#include <array>
#include <initializer_list>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "robsim/base/geometry.hpp"
#include "robsim/imaging/plane_map.hpp"
#include "robsim/model/robot_model.hpp"
#include "robsim/vision/locate.hpp"

namespace robsim::bindings {

namespace py = pybind11;

// Objects that accept any value, because functions convert them that raise the errors.
inline bool is_anything(PyObject* value) { return value != nullptr; }

/// Numbers for an array whose shape depends on the other arguments.
class ArrayLike : public py::object {
 public:
  PYBIND11_OBJECT_DEFAULT(ArrayLike, py::object, is_anything)
};

/// The pixels of an image that is written, or kept.
class PixelArray : public py::object {
 public:
  PYBIND11_OBJECT_DEFAULT(PixelArray, py::object, is_anything)
};

/// A Frame or the pixels of an image.
struct ImageLike {
  ImageView view;
  const Frame* frame = nullptr;  // null: there are pixels alone

  PlaneMap plane_map() const { return frame ? frame->plane_map : PlaneMap(); }
};

/// A Measurement or its pose.
struct MeasurementLike : Measurement {};

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
/// Throws py::type_error or py::value_error that names the argument and the expected value.
Doubles doubles_from(py::handle value, const std::string& name, const std::optional<Shape>& shape,
                     const std::string& expected);

/// The function of a number for a number, an array of them for an array.
py::object for_each_number(py::handle value, const std::string& name, const std::string& expected,
                           double (*function)(double));

/// Two numbers, a tuple in Python.
using Pair = std::array<double, 2>;
Pair pair_from(py::handle value, const std::string& name);

Pose pose_from(py::handle value, const std::string& name);
Point point_from(py::handle value, const std::string& name);
Input input_from(py::handle value, const std::string& name);
Polygon polygon_from(py::handle value, const std::string& name);
AxisMatrix axis_matrix_from(py::handle value, const std::string& name);

Eigen::Matrix3d matrix_from(py::handle value, const std::string& name);

/// Throws ValueError for variances below 0.
PoseCovariance covariance_from(py::handle value, const std::string& name);

/// Any numbers, NaN and infinity too.
Eigen::VectorXd vector_from(py::handle value, const std::string& name);

/// A number in pickles.
DetectionResult detection_result_from(py::handle value, const std::string& name);
inline py::int_ to_array(DetectionResult result) { return static_cast<int>(result); }

/// A measurement of nothing but a pose.
Measurement measured_pose_from(py::handle value, const std::string& name);
/// A Measurement, or a pose without anything else.
MeasurementLike measurement_from(py::handle value, const std::string& name);

/// Throws py::value_error unless it is the number of a step.
inline void check_step_number(std::int64_t k) {
  if (k < 0) throw py::value_error("k must be at least 0, got " + std::to_string(k));
}

inline py::tuple to_array(const Pair& pair) { return py::make_tuple(pair[0], pair[1]); }

template <typename T>
py::array_t<T> read_only(py::array_t<T> array) {
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

/// Keeps a value as long as arrays look at its memory.
template <typename T>
py::capsule owner_of(T* value) {
  return py::capsule(value, [](void* p) { delete static_cast<T*>(p); });
}

/// A read-only copy.
inline py::array_t<double> to_array(const double* values, const Shape& shape) {
  return read_only(py::array_t<double>(shape, values));
}
inline py::array_t<double> to_array(std::initializer_list<double> values) {
  return to_array(values.begin(), {static_cast<py::ssize_t>(values.size())});
}
inline py::array_t<double> to_array(const Pose& p) { return to_array({p.x, p.y, p.heading}); }
inline py::array_t<double> to_array(const Point& p) { return to_array({p.x, p.y}); }
inline py::array_t<double> to_array(const Input& u) { return to_array({u.u1, u.u2}); }

template <typename Derived>
py::array_t<double> to_array(const Eigen::MatrixBase<Derived>& matrix) {
  const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> rows = matrix;
  if (Derived::IsVectorAtCompileTime) return to_array(rows.data(), Shape{rows.size()});
  return to_array(rows.data(), Shape{rows.rows(), rows.cols()});
}

/// A view of the caller's uint8 RGB pixels, shape (H, W, 3), rows of any stride. Copies nothing.
ImageView image_view(py::handle value, const std::string& name);

/// A Python object that may be released without the interpreter lock, in any thread.
using SharedObject = std::shared_ptr<PyObject>;
SharedObject shared_object(py::object object);

/// An image on the memory of an array as `image_view` has them, or of any buffer of that type and
/// shape: read-only, and keeps it alive. Copies nothing.
Image borrowed_image(py::handle value, const std::string& name);

/// The same, but writable.
Image writable_image(py::handle value, const std::string& name);

/// A Frame, or pixels as `image_view` has them.
ImageLike image_from(py::handle value, const std::string& name);

/// The box of (left, top, right, bottom), all four included.
PixelBox region_from(py::handle value, const std::string& name);

/// As `image_view`, but writable; rows must not overlap.
WritableView writable_view(py::handle value, const std::string& name);

/// A read-only view of shape (H, W, 3) that keeps the image's pixels alive.
py::array_t<std::uint8_t> to_array(const Image& image);

/// The names of an enumeration's values.
template <typename T>
using Choices = std::initializer_list<std::pair<const char*, T>>;
template <typename T>
constexpr std::nullptr_t choices = nullptr;
template <typename T>
constexpr bool has_choices = std::is_same_v<decltype(choices<T>), const Choices<T>>;

template <typename T>
T choice_from(py::handle value, const std::string& name) {
  std::string names;
  for (const auto& [key, choice] : choices<T>) {
    if (PyUnicode_Check(value.ptr()) && value.equal(py::str(key))) return choice;
    names += (names.empty() ? "'" : ", '") + std::string(key) + "'";
  }
  const std::string message = name + " must be one of " + names + ", got " + describe(value);
  if (PyUnicode_Check(value.ptr())) throw py::value_error(message);
  throw py::type_error(message);
}

template <typename T>
std::enable_if_t<has_choices<T>, py::str> to_array(const T& choice) {
  for (const auto& [key, value] : choices<T>) {
    if (value == choice) return key;
  }
  return "";
}

/// How arguments become values of the core's types: `from` throws py::type_error, py::value_error
/// or std::invalid_argument that names the argument; `type` is what help and the stub show.
template <typename T, typename = void>
struct Conversion;

template <auto convert, const auto& shown>
struct By {
  static constexpr auto from = convert;
  static constexpr auto type = shown;
};

inline constexpr auto arrays =
    py::detail::io_name("numpy.typing.ArrayLike", "numpy.typing.NDArray[numpy.float64]");
inline constexpr auto pixels = py::detail::const_name("numpy.typing.NDArray[numpy.uint8]");
inline constexpr auto images =
    py::detail::const_name("robsim.Frame | numpy.typing.NDArray[numpy.uint8]");
inline constexpr auto measurements =
    py::detail::const_name("robsim.Measurement | numpy.typing.ArrayLike");
inline constexpr auto ints = py::detail::const_name("int");
inline constexpr auto pairs = py::detail::io_name("numpy.typing.ArrayLike", "tuple[float, float]");
inline constexpr auto regions = py::detail::const_name("collections.abc.Sequence[int]");

template <>
struct Conversion<Pose> : By<&pose_from, arrays> {};
template <>
struct Conversion<Point> : By<&point_from, arrays> {};
template <>
struct Conversion<Input> : By<&input_from, arrays> {};
template <>
struct Conversion<Polygon> : By<&polygon_from, arrays> {};
template <>
struct Conversion<AxisMatrix> : By<&axis_matrix_from, arrays> {};
template <>
struct Conversion<Eigen::Matrix3d> : By<&matrix_from, arrays> {};
template <>
struct Conversion<PoseCovariance> : By<&covariance_from, arrays> {};
template <>
struct Conversion<Eigen::VectorXd> : By<&vector_from, arrays> {};
template <>
struct Conversion<MeasurementLike> : By<&measurement_from, measurements> {};
template <>
struct Conversion<Image> : By<&borrowed_image, pixels> {};
template <>
struct Conversion<ImageView> : By<&image_view, pixels> {};
template <>
struct Conversion<ImageLike> : By<&image_from, images> {};
template <>
struct Conversion<PixelBox> : By<&region_from, regions> {};
template <>
struct Conversion<DetectionResult> : By<&detection_result_from, ints> {};
template <>
struct Conversion<Pair> : By<&pair_from, pairs> {};
template <typename T>
struct Conversion<T, std::enable_if_t<has_choices<T>>> {
  static constexpr auto from = &choice_from<T>;
  static constexpr auto type = py::detail::const_name("str");
};

template <typename T, typename = void>
constexpr bool is_converted = false;
template <typename T>
constexpr bool is_converted<T, std::void_t<decltype(Conversion<T>::from)>> = true;

/// The name of a colour, checked. `what` it is called in the message.
inline std::string name_from(const pybind11::str& name, const char* what = "name") {
  return py::module_::import("robsim.base.checks")
      .attr("check_words")(what, name)
      .cast<std::string>();
}

}  // namespace robsim::bindings

namespace pybind11::detail {

template <>
struct handle_type_name<robsim::bindings::ArrayLike> {
  static constexpr auto name = const_name("numpy.typing.ArrayLike");
};
template <>
struct handle_type_name<robsim::bindings::PixelArray> {
  static constexpr auto name = const_name("numpy.typing.NDArray[numpy.uint8]");
};

template <typename T>
struct converting_caster {
  PYBIND11_TYPE_CASTER(T, robsim::bindings::Conversion<T>::type);

  /// An error has no text here: the signature of the function calls the conversion again, with the
  /// name of the argument.
  bool load(handle source, bool) {
    try {
      value = robsim::bindings::Conversion<T>::from(source, "");
      return true;
    } catch (const builtin_exception&) {
    } catch (const std::invalid_argument&) {
    }
    return false;
  }

  static handle cast(const T& from, return_value_policy, handle) {
    return robsim::bindings::to_array(from).release();
  }
};

template <typename T>
struct type_caster<T, enable_if_t<robsim::bindings::is_converted<T>>> : converting_caster<T> {};
template <>
struct type_caster<robsim::Polygon> : converting_caster<robsim::Polygon> {};
template <>
struct type_caster<robsim::bindings::Pair> : converting_caster<robsim::bindings::Pair> {};
template <typename T>
struct type_caster_enum_type_enabled<T, enable_if_t<robsim::bindings::is_converted<T>>>
    : std::false_type {};

}  // namespace pybind11::detail
