#include "python/numpy.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace robsim::bindings {

namespace {

constexpr py::ssize_t maximum_repr = 80;

// A fast path for tuples of floats, as callbacks return them. Anything else, nullopt here, is left
// to numpy.
template <std::size_t count>
std::optional<std::array<double, count>> floats_from(py::handle value) {
  if (!PyTuple_CheckExact(value.ptr()) || PyTuple_GET_SIZE(value.ptr()) != count) return {};
  std::array<double, count> numbers;
  for (std::size_t i = 0; i < count; ++i) {
    PyObject* const item = PyTuple_GET_ITEM(value.ptr(), static_cast<py::ssize_t>(i));
    if (!PyFloat_CheckExact(item)) return {};
    numbers[i] = PyFloat_AS_DOUBLE(item);
    if (!std::isfinite(numbers[i])) return {};
  }
  return numbers;
}

bool fits(const py::array& array, const Shape& shape) {
  if (array.ndim() != static_cast<py::ssize_t>(shape.size())) return false;
  for (std::size_t i = 0; i < shape.size(); ++i) {
    if (shape[i] >= 0 && array.shape(static_cast<py::ssize_t>(i)) != shape[i]) return false;
  }
  return true;
}

// The repr of anything: of an object whose repr fails, its type; without control characters.
py::str printable_repr(py::handle value) {
  py::str text;
  try {
    text = py::repr(value);
  } catch (const py::error_already_set& error) {
    if (!error.matches(PyExc_Exception)) throw;  // KeyboardInterrupt
    text = "an object of " + py::type::of(value).attr("__name__").cast<std::string>();
  }
  if (text.attr("isprintable")().cast<bool>()) return text;
  return text.attr("encode")("unicode_escape").attr("decode")("ascii");
}

}  // namespace

std::string shape_text(const py::ssize_t* sizes, py::ssize_t dimensions) {
  std::string text = "(";
  for (py::ssize_t i = 0; i < dimensions; ++i) text += (i ? ", " : "") + std::to_string(sizes[i]);
  return text + (dimensions == 1 ? ",)" : ")");
}

std::string describe(py::handle value) {
  if (py::isinstance<py::array>(value)) {
    const auto array = py::reinterpret_borrow<py::array>(value);
    return "a " + py::str(array.dtype()).cast<std::string>() + " array of shape " +
           shape_text(array.shape(), array.ndim());
  }
  const py::str text = printable_repr(value);
  if (py::len(text) <= maximum_repr) return text.cast<std::string>();
  // Cut as text, not as bytes: a character may have several.
  return text[py::slice(0, maximum_repr, 1)].cast<std::string>() + " ...";
}

Doubles numbers_from(py::handle value, const std::string& name, const std::optional<Shape>& shape,
                     const std::string& expected) {
  const auto message = [&] { return name + " must be " + expected + ", got " + describe(value); };
  if (value.is_none() || py::isinstance<py::str>(value)) throw py::type_error(message());
  if (py::isinstance<Doubles>(value)) {
    auto array = py::reinterpret_borrow<Doubles>(value);
    if (shape && !fits(array, *shape)) throw py::value_error(message());
    return array;
  }
  const py::array given = [&] {
    try {
      return py::array(py::reinterpret_borrow<py::object>(value));
    } catch (const py::error_already_set& error) {
      // Anything else, such as KeyboardInterrupt, passes.
      if (error.matches(PyExc_TypeError) || error.matches(PyExc_ValueError)) {
        throw py::type_error(message());
      }
      throw;
    }
  }();
  // Real numbers only: no text, dates, complex numbers or objects (very large ints among them).
  if (std::string("biuf").find(given.dtype().kind()) == std::string::npos) {
    throw py::type_error(message());
  }
  if (shape && !fits(given, *shape)) throw py::value_error(message());
  return Doubles(given);
}

Doubles doubles_from(py::handle value, const std::string& name, const std::optional<Shape>& shape,
                     const std::string& expected) {
  const Doubles array = numbers_from(value, name, shape, expected);
  const double* numbers = array.data();
  if (!std::all_of(numbers, numbers + array.size(), [](double x) { return std::isfinite(x); })) {
    throw py::value_error(name + " must be " + expected + ", all finite, got " +
                          describe(array.attr("tolist")()));
  }
  return array;
}

py::object for_each_number(py::handle value, const std::string& name, const std::string& expected,
                           double (*function)(double)) {
  if (PyFloat_Check(value.ptr())) return py::float_(function(value.cast<double>()));
  const Doubles numbers = numbers_from(value, name, std::nullopt, expected);
  Doubles result(Shape(numbers.shape(), numbers.shape() + numbers.ndim()));
  std::transform(numbers.data(), numbers.data() + numbers.size(), result.mutable_data(), function);
  if (result.ndim() == 0) return py::float_(*result.data());
  return std::move(result);
}

Pair pair_from(py::handle value, const std::string& name) {
  if (const auto numbers = floats_from<2>(value)) return *numbers;
  const Doubles two = doubles_from(value, name, Shape{2}, "two numbers");
  return {two.at(0), two.at(1)};
}

Pose pose_from(py::handle value, const std::string& name) {
  return measured_pose_from(value, name).pose;
}

Point point_from(py::handle value, const std::string& name) {
  const Doubles p = doubles_from(value, name, Shape{2}, "a point (x, y)");
  return {p.at(0), p.at(1)};
}

Input input_from(py::handle value, const std::string& name) {
  if (const auto u = floats_from<2>(value)) return {(*u)[0], (*u)[1]};
  const Doubles u = doubles_from(value, name, Shape{2}, "(u1, u2), the two voltages in V");
  return {u.at(0), u.at(1)};
}

Polygon polygon_from(py::handle value, const std::string& name) {
  const Doubles points = doubles_from(value, name, Shape{-1, 2}, "a polygon, shape (N, 2)");
  Polygon polygon;
  for (py::ssize_t i = 0; i < points.shape(0); ++i) {
    polygon.push_back({points.at(i, 0), points.at(i, 1)});
  }
  check_polygon(polygon, name);
  return polygon;
}

AxisMatrix axis_matrix_from(py::handle value, const std::string& name) {
  const Doubles m = doubles_from(value, name, Shape{3, 5}, "the 15 parameters, shape (3, 5)");
  return Eigen::Map<const AxisMatrix>(m.data());
}

Eigen::Matrix3d matrix_from(py::handle value, const std::string& name) {
  const Doubles rows = doubles_from(value, name, Shape{3, 3}, "an array of shape (3, 3)");
  return Eigen::Map<const PoseCovariance>(rows.data());
}

PoseCovariance covariance_from(py::handle value, const std::string& name) {
  const PoseCovariance P = matrix_from(value, name);
  if (!(P.diagonal().array() < 0).any()) return P;
  throw py::value_error(name + " must have variances of at least 0 on its diagonal, got " +
                        describe(py::float_(P.diagonal().minCoeff())));
}

Eigen::VectorXd vector_from(py::handle value, const std::string& name) {
  const Doubles numbers = numbers_from(value, name, Shape{-1}, "an array of shape (n,)");
  return Eigen::Map<const Eigen::VectorXd>(numbers.data(), numbers.size());
}

DetectionResult detection_result_from(py::handle value, const std::string& name) {
  const int result = value.cast<int>();
  if (result >= 0 && result <= static_cast<int>(last_result)) {
    return static_cast<DetectionResult>(result);
  }
  throw py::value_error(name + " must be the result of a Detection, got " + describe(value));
}

Measurement measured_pose_from(py::handle value, const std::string& name) {
  Measurement measurement;
  if (const auto p = floats_from<3>(value)) {
    measurement.pose = {(*p)[0], (*p)[1], (*p)[2]};
  } else {
    const Doubles rows =
        doubles_from(value, name, Shape{3}, "a pose (x, y, heading) in px, px and rad");
    measurement.pose = {rows.at(0), rows.at(1), rows.at(2)};
  }
  measurement.given_heading = measurement.pose.heading;
  measurement.pose.heading = wrap_angle(measurement.pose.heading);
  return measurement;
}

MeasurementLike measurement_from(py::handle value, const std::string& name) {
  if (py::isinstance<Measurement>(value)) return {value.cast<Measurement>()};
  return {measured_pose_from(value, name)};
}

ImageView image_view(py::handle value, const std::string& name) {
  const std::string expected = name + " must be a uint8 RGB array of shape (H, W, 3), got ";
  if (!py::isinstance<py::array>(value)) throw py::type_error(expected + describe(value));
  const auto array = py::reinterpret_borrow<py::array>(value);
  if (array.dtype().num() != py::dtype::of<std::uint8_t>().num()) {
    throw py::type_error(expected + describe(value));
  }
  if (array.ndim() != 3 || array.shape(2) != 3) throw py::value_error(expected + describe(value));
  if (array.size() == 0) throw py::value_error(expected + "an empty one: " + describe(value));
  if (std::max(array.shape(0), array.shape(1)) > 65535) {
    throw py::value_error(name + " must be at most 65535 px wide and high, got " + describe(value));
  }
  if (array.strides(2) != 1 || (array.strides(1) != 3 && array.shape(1) > 1)) {
    throw py::value_error(name + " must have its pixels side by side in memory, got strides " +
                          py::str(array.attr("strides")).cast<std::string>() +
                          ": pass numpy.ascontiguousarray(" + name + ")");
  }
  return {static_cast<const std::uint8_t*>(array.data()), static_cast<int>(array.shape(1)),
          static_cast<int>(array.shape(0)), array.strides(0)};
}

SharedObject shared_object(py::object object) {
  return {object.release().ptr(), [](PyObject* held) {
            if (!Py_IsInitialized()) return;
            const py::gil_scoped_acquire interpreter;
            Py_DECREF(held);
          }};
}

Image borrowed_image(py::handle value, const std::string& name) {
  auto array = py::reinterpret_borrow<py::object>(value);
  if (PyObject_CheckBuffer(value.ptr())) array = py::array(array);
  const ImageView view = image_view(array, name);
  return {view, shared_object(std::move(array))};
}

Image writable_image(py::handle value, const std::string& name) {
  const WritableView view = writable_view(value, name);
  return {view, shared_object(py::reinterpret_borrow<py::object>(value))};
}

ImageLike image_from(py::handle value, const std::string& name) {
  if (!py::isinstance<Frame>(value)) return {image_view(value, name)};
  const auto& frame = value.cast<const Frame&>();
  return {frame.image.view(), &frame};
}

PixelBox region_from(py::handle value, const std::string& name) {
  try {
    const auto [left, top, right, bottom] = value.cast<std::tuple<int, int, int, int>>();
    constexpr int maximum = std::numeric_limits<int>::max() - 1;
    return {left, top, std::min(right, maximum) + 1, std::min(bottom, maximum) + 1};
  } catch (const py::cast_error&) {
    throw py::type_error(name + " must be (left, top, right, bottom), four ints, got " +
                         describe(value));
  }
}

WritableView writable_view(py::handle value, const std::string& name) {
  const ImageView view = image_view(value, name);
  auto array = py::reinterpret_borrow<py::array>(value);
  if (!array.writeable()) throw py::value_error(name + " must not be read-only");
  if (view.stride < std::ptrdiff_t{3} * view.width && view.height > 1) {
    throw py::value_error(name + " must have its rows one after the other in memory");
  }
  return {static_cast<std::uint8_t*>(array.mutable_data()), view.width, view.height, view.stride};
}

py::array_t<std::uint8_t> to_array(const Image& image) {
  const ImageView view = image.view();
  return read_only(py::array_t<std::uint8_t>(
      {py::ssize_t{view.height}, py::ssize_t{view.width}, py::ssize_t{3}},
      {view.stride, py::ssize_t{3}, py::ssize_t{1}}, view.data, owner_of(new Image(image))));
}

}  // namespace robsim::bindings
