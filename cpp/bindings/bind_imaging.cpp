#include <algorithm>
#include <cmath>
#include <map>

#include "python/interpreter.hpp"
#include "python/values.hpp"
#include "robsim/imaging/plane_map.hpp"
#include "robsim/imaging/raw/pixel_format.hpp"
#include "robsim/imaging/resampling.hpp"

using namespace robsim;
using namespace robsim::bindings;

namespace {

constexpr int notebook_width = 480;  // px; a camera's frame would fill the screen

using Seconds = std::optional<double>;

void check_time(const Seconds& time, const char* name) {
  if (time && !std::isfinite(*time))
    throw py::value_error(std::string(name) + " must be finite (s)");
}

Frame frame_with(Image image, const Seconds& t, const Seconds& t_arrival, const Seconds& epoch,
                 std::int64_t index, const PlaneMap& plane_map, std::optional<int> headings) {
  check_time(t, "t");
  check_time(t_arrival, "t_arrival");
  check_time(epoch, "epoch");
  if (index < 0) throw py::value_error("index must be at least 0");
  if (headings && *headings < 1) {
    throw py::value_error("headings must be at least 1, or None, got " + std::to_string(*headings));
  }
  return {std::move(image), t, t_arrival, epoch, index, plane_map, headings.value_or(0)};
}

Frame make_frame(const PixelArray& image, bool copy, const Seconds& t, const Seconds& t_arrival,
                 const Seconds& epoch, std::int64_t index, const PlaneMap& plane_map,
                 std::optional<int> headings) {
  return frame_with(copy ? copy_of(image_view(image, "image")) : borrowed_image(image, "image"), t,
                    t_arrival, epoch, index, plane_map, headings);
}

// A frame of a copy of the pixels.
template <Image (*copied)(const ImageView&)>
Frame frame_of(const ImageView& image, const Seconds& t, const Seconds& t_arrival,
               const Seconds& epoch, std::int64_t index, const PlaneMap& plane_map,
               std::optional<int> headings) {
  return frame_with(copied(image), t, t_arrival, epoch, index, plane_map, headings);
}

std::optional<int> headings_of(const Frame& frame) {
  return frame.headings ? std::optional(frame.headings) : std::nullopt;
}

void bind_frame(py::module_& module) {
  Class<Frame> frame(public_in(module, "robsim"), "Frame", R"(
A camera image with its time: the only data about the world for the robot's software.

The pixels are RGB. OpenCV's pixels are BGR: use `Frame.from_bgr` for these. Otherwise the red and
the blue marker are swapped, and the measured pose has the wrong direction and position.

Parameters
----------
image : array (H, W, 3) of uint8
    RGB pixels. With ``copy=False``, any buffer of this type and shape is accepted.
copy : bool
    False: use the array's own memory, such as shared memory. The frame keeps the array alive and
    always shows its current content. Overwriting the memory changes the frame, its hash and its
    equality.
t : float, optional
    Time (s), of the exposure if the camera knows it. None: the frame has no time.
t_arrival : float, optional
    Arrival at this computer, by the clock of `t` (s).
epoch : float, optional
    ``time.monotonic()`` when `t` was 0 (s).
index : int
    Number of the frame.
plane_map : PlaneMap, optional
    Pixels to work area. Default: the identity.
headings : int, optional
    Number of drawn headings of the robot, at whole pixels, as in frames of a simulation. This
    rounding limits the accuracy of a measured pose, and the covariance includes it. By default any
    heading is possible, as in a real camera's frames. A frame made only from the pixels of a
    simulated frame needs this number.

Examples
--------
A frame of shared memory keeps that memory open. Here a ``bytearray`` has its place:

>>> memory = bytearray(480 * 640 * 3)
>>> frame = robsim.Frame(memoryview(memory).cast("B", (480, 640, 3)), copy=False, t=0.2)
>>> memory[0] = 255
>>> frame.image[0, 0].tolist(), frame.t
([255, 0, 0], 0.2)
)");
  frame
      .def(py::init(&make_frame), "image"_a, py::kw_only(), "copy"_a.noconvert() = true,
           "t"_a = py::none(), "t_arrival"_a = py::none(), "epoch"_a = py::none(), "index"_a = 0,
           "plane_map"_a = PlaneMap(), "headings"_a = py::none())
      .def_static("from_bgr", &frame_of<&copy_of_bgr>, "image"_a, py::kw_only(), "t"_a = py::none(),
                  "t_arrival"_a = py::none(), "epoch"_a = py::none(), "index"_a = 0,
                  "plane_map"_a = PlaneMap(), "headings"_a = py::none(), R"(
Return the frame of an image in BGR, OpenCV's order: a copy.

Parameters
----------
image : array (H, W, 3) of uint8
    BGR pixels, as from ``cv2.imread`` and ``cv2.VideoCapture``.
t, t_arrival, epoch, index, plane_map, headings
    As for `Frame`.

Examples
--------
>>> blue = np.uint8([[[255, 0, 0]]])
>>> robsim.Frame.from_bgr(blue).image[0, 0].tolist()
[0, 0, 255]
)")
      .def(
          "_repr_png_",
          [](const Frame& self) -> std::pair<py::bytes, std::map<std::string, int>> {
            // The core knows no codecs: the package's own one does it.
            const py::bytes png =
                py::module_::import("robsim.vision.imaging.images").attr("png_bytes")(self.image);
            return {png, {{"width", std::min(self.image.width(), notebook_width)}}};
          },
          "Return the image as a PNG file and its displayed width: notebooks display a frame.")
      .def(
          "__array__",
          [](const Frame& self, const py::object& dtype, const py::object& copy) {
            const py::array pixels = to_array(self.image);
            const bool is_copied = !copy.is_none() && copy.cast<bool>();
            const py::object kind = dtype.is_none() ? py::object(pixels.dtype()) : dtype;
            return pixels.attr("astype")(kind, "copy"_a = is_copied);
          },
          "dtype"_a = py::none(), "copy"_a = py::none(),
          "Return the image, so that numpy and matplotlib accept a frame as its pixels.")
      .def("__repr__", [](const Frame& self) {
        const char* const text =
            self.t ? "<Frame {}: {} x {} px, t = {:g} s>" : "<Frame {}: {} x {} px>";
        return py::str(text).format(self.index, self.image.width(), self.image.height(), self.t);
      });
  const auto make = [](const py::array& image, const Seconds& t, const Seconds& t_arrival,
                       const Seconds& epoch, std::int64_t index, const PlaneMap& plane_map,
                       std::optional<int> headings) {
    const py::object whole = py::module_::import("numpy").attr("ascontiguousarray")(image);
    return frame_with(copy_of(image_view(whole, "image")), t, t_arrival, epoch, index, plane_map,
                      headings);
  };
  define_record(
      frame,
      Fields(
          make,
          Field("image", &Frame::image,
                "array (H, W, 3) of uint8: RGB, read-only. Without ``copy=False`` it is "
                "C-contiguous and\nnever overwritten while you hold it."),
          Field("t", &Frame::t, "float or None: time (s)."),
          Field("t_arrival", &Frame::t_arrival,
                "float or None: arrival at this computer, by the clock of `t` (s)."),
          Field("epoch", &Frame::epoch, "float or None: ``time.monotonic()`` when `t` was 0 (s)."),
          Field("index", &Frame::index, "int: number of the frame."),
          Field("plane_map", &Frame::plane_map, "PlaneMap: pixels <-> work area."),
          Field("headings", &headings_of, "int or None: number of drawn headings of the robot.")));
}

void bind_reduce(const py::module_& module) {
  Module(module).def(
      "reduced",
      [](const Frame& frame, int width) {
        if (width < 1) throw py::value_error("width must be 1 px at least");
        const WithoutInterpreter native;
        return reduced(frame.image, width);
      },
      "frame"_a, "width"_a,
      "Return a frame's pixels, reduced by whole factors to not less than a width; incomplete "
      "pixels at the right and below are dropped.");
}

void bind_warp(py::module_& module) {
  Class<Warp, std::shared_ptr<Warp>>(public_in(module, "robsim._core"), "Warp",
                                     "Makes an image from another by moving each pixel.")
      .def(
          "apply",
          [](const Warp& self, const ImageView& image) {
            const WithoutInterpreter native;
            Image warped(self.width(), self.height());
            self.apply(image, warped.writable_view());
            return warped;
          },
          "image"_a);
}

Image rgb_of(const ArrayLike& raw, int width, int height, const std::string& format, int bits) {
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
  const WithoutInterpreter native;
  Image image(width, height);
  to_rgb(view, image.writable_view());
  return image;
}

using FormatRow = std::tuple<const char*, const char*, int, const char*>;

std::vector<FormatRow> format_rows() {
  std::vector<FormatRow> rows;
  for (const PixelFormat& one : pixel_formats()) {
    rows.emplace_back(one.name, one.coding, one.iidc.worth, one.genicam.name);
  }
  return rows;
}

}  // namespace

void bind_imaging(py::module_& module) {
  bind_frame(module);
  bind_reduce(module);
  bind_warp(module);
  public_in(module, "robsim._core")
      .def("to_rgb", &rgb_of, "raw"_a, "width"_a, "height"_a, "format"_a, "bits"_a = 16, R"(
Return the pixels of a camera as RGB.

Parameters
----------
raw : buffer of bytes
    The rows, without gaps.
width, height : int
    Size of the frame (px).
format : str
    The camera's pixel format: a name in `pixel_formats`.
bits : int
    Number of used bits of the 16 in ``"mono16"``.

Returns
-------
array (H, W, 3) of uint8
    The image, read-only.

Raises
------
TypeError, ValueError
    If there are too few bytes, or the format does not have that size.
)")
      .def("pixel_formats", &format_rows,
           "Return the cameras' pixel formats: name, coding, rank on FireWire (0: no rank), name "
           "in GenICam (empty: no name), for GenICam in the order of rank.");
}
