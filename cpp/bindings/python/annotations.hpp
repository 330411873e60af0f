// What help and the stub say of arguments that take more than one type. They accept any value:
// conversions in numpy.hpp say what is wrong with it.
#pragma once

#include <pybind11/pybind11.h>

namespace robsim::bindings {

namespace py = pybind11;

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
