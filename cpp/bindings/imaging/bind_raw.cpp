#include <pybind11/pybind11.h>

#include <string>

#include "python/interpreter.hpp"
#include "python/numpy.hpp"
#include "python/public_names.hpp"
#include "python/signature.hpp"
#include "robsim/imaging/raw/pixel_format.hpp"

namespace py = pybind11;
using namespace robsim;
using namespace robsim::bindings;

namespace {

py::array_t<std::uint8_t> rgb_of(const ArrayLike& raw, int width, int height,
                                 const std::string& format, int bits) {
  if (!py::isinstance<py::buffer>(raw)) {
    throw py::type_error("raw must be a buffer of bytes, got " + describe(raw));
  }
  const py::buffer_info bytes = py::reinterpret_borrow<py::buffer>(raw).request();
  if (bytes.itemsize != 1 || !PyBuffer_IsContiguous(bytes.view(), 'C')) {
    throw py::value_error("raw must be bytes without gaps, got " + describe(raw));
  }
  RawView view =
      raw_view(static_cast<const std::uint8_t*>(bytes.ptr), static_cast<std::size_t>(bytes.size),
               pixel_format_named(format), width, height);
  view.bits = bits;
  Image image(width, height);
  {
    const WithoutInterpreter native;
    to_rgb(view, image.writable_view());
  }
  return image_array(image);
}

}  // namespace

void bind_raw(py::module_& module) {
  Module(public_in(module, "robsim._core"))
      .def("to_rgb", &rgb_of, py::arg("raw"), py::arg("width"), py::arg("height"),
           py::arg("format"), py::arg("bits") = 16, R"(
Return the pixels of a camera as RGB.

Parameters
----------
raw : buffer of bytes
    The rows, without gaps.
width, height : int
    Size of the frame (px).
format : str
    How the camera sends pixels: ``"mono8"``, ``"mono16"``, ``"yuv411"``, ``"yuv422"``,
    ``"yuv444"``, ``"rgb8"``, ``"bayer_rggb"``, ``"bayer_grbg"``, ``"bayer_gbrg"`` or
    ``"bayer_bggr"``.
bits : int
    That a camera in ``"mono16"`` uses of the 16.

Returns
-------
array (H, W, 3) of uint8
    The image, read-only.

Raises
------
TypeError, ValueError
    If there are too few bytes, or the format does not have that size.
)");
}
