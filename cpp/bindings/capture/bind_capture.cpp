#include <algorithm>
#include <cstdint>
#include <functional>
#include <string_view>

#include "capture/capture_errors.hpp"
#include "capture/python_camera.hpp"
#include "python/interpreter.hpp"
#include "python/signature.hpp"
#include "robsim/base/system.hpp"
#include "robsim/lab/capture/grabber.hpp"
#include "robsim/lab/capture/whole_jpeg.hpp"

using namespace robsim;
using namespace robsim::bindings;

namespace {

constexpr double look = 0.1;  // s, after which a Ctrl-C is noticed

// Waits without the interpreter, and looks at signals in between.
template <typename Result>
Result wait(double timeout, const std::function<Result(double)>& wait_for) {
  const double end = monotonic_now() + timeout;
  while (true) {
    const double left = std::max(0.0, end - monotonic_now());
    const Result result = natively([&] { return wait_for(std::min(left, look)); });
    if (PyErr_CheckSignals()) throw py::error_already_set();
    if (result || left <= look) return result;
  }
}

using Size = std::optional<std::pair<int, int>>;

std::shared_ptr<Grabber> make_grabber(const std::shared_ptr<CaptureDevice>& device, int every,
                                      double frame_timeout, bool reopen,
                                      std::optional<double> interval,
                                      const std::optional<PlaneMap>& plane_map, const Size& area,
                                      const Size& size, std::optional<int> headings) {
  if (every < 1) throw py::value_error("every must be at least 1");
  GrabberOptions options;
  options.every = every;
  options.frame_timeout = frame_timeout;
  options.reopen = reopen;
  options.interval = interval;
  options.plane_map = plane_map;
  options.area = area;
  options.size = size;
  options.headings = headings.value_or(0);
  return make_native<Grabber>(device, options);
}

std::array<std::int64_t, 6> counts_of(const Grabber& grabber) {
  const CaptureCounts counts = grabber.counts();
  return {counts.grabbed, counts.delivered, counts.dropped,
          counts.torn,    counts.timeouts,  counts.reopened};
}

}  // namespace

void bind_capture(py::module_& module) {
  translate_capture_errors<&raise_camera_error>();
  Class<CaptureDevice, std::shared_ptr<CaptureDevice>>(
      public_in(module, "robsim._core"), "CaptureDevice",
      "A camera for a grabber. Users take robsim.Camera.");
  Class<PythonCamera, CaptureDevice, std::shared_ptr<PythonCamera>>(
      public_in(module, "robsim._core"), "PythonCamera", R"(
A camera in Python, called in the grabber's thread.

Parameters
----------
camera : object
    With ``open()`` and ``close()``, called in turn any number of times, and ``read()``. ``read()``
    returns None if no frame came within 0.1 s or so, or a pair (image, exposed). The image is a
    uint8 array (H, W, 3), or None if it was torn; exposed is the time of its exposure
    (``time.monotonic()``, s), or None if unknown. Three numbers may follow: the time of its arrival
    (the same clock, s), the number of complete images skipped before this one, and of torn ones.
    All three methods raise CaptureError.
bgr : bool
    Whether the images are in OpenCV's order; otherwise they are RGB.
)")
      .def(py::init<py::object, bool>(), "camera"_a, py::kw_only(), "bgr"_a = false);
  Class<StreamedCamera, CaptureDevice, std::shared_ptr<StreamedCamera>>(
      public_in(module, "robsim._core"), "StreamedCamera",
      "A camera that another process reads: open() of its object returns the descriptor of a "
      "socket for the frames, and close() ends the process.")
      .def(py::init<py::object>(), "camera"_a);
  Class<Grabber, std::shared_ptr<Grabber>>(
      public_in(module, "robsim._core"), "Grabber",
      "The thread that reads a camera. Users take robsim.Camera.")
      .def(py::init(&make_grabber), "device"_a, py::kw_only(), "every"_a = 1,
           "frame_timeout"_a = 1.0, "reopen"_a = false, "interval"_a = py::none(),
           "plane_map"_a = py::none(), "area"_a = py::none(), "size"_a = py::none(),
           "headings"_a = py::none())
      .def(
          "wait_for_size",
          [](const Grabber& self, double timeout) {
            return wait<Size>(timeout, [&](double s) { return self.wait_for_size(s); });
          },
          "timeout"_a, "Return (width, height) of the first frame; None without a frame.")
      .def(
          "__call__",
          [](Grabber& self, double timeout) {
            return wait<std::optional<Frame>>(timeout, [&](double s) { return self.take(s); });
          },
          "timeout"_a, "Return the newest frame if it was not taken yet, else None.")
      .def_property_readonly("newest", &Grabber::newest, "Frame or None: the last taken frame.")
      .def_property_readonly("kept_rate", &Grabber::kept_rate,
                             "The actual and the promised frame rate (1/s); None: they are equal.")
      .def_property_readonly("counts", &counts_of,
                             "list of int: grabbed, delivered, dropped, torn, timeouts, reopened.")
      .def(
          "close", [](Grabber& self, double patience) { self.close(patience); }, "patience"_a = 1.0,
          py::call_guard<WithoutInterpreter>(),
          "End the thread; abandon it if it hangs for `patience` s.");
  public_in(module, "robsim._core")
      .def(
          "is_whole_jpeg",
          [](const py::bytes& data) {
            const std::string_view view(data);
            const WithoutInterpreter work;
            return is_whole_jpeg(reinterpret_cast<const std::uint8_t*>(view.data()), view.size());
          },
          "data"_a, "Return whether a JPEG image has all of its blocks, and its end.");
}
