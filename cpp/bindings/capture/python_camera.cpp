#include "capture/python_camera.hpp"

#include <optional>
#include <utility>

#include "capture/capture_errors.hpp"
#include "python/interpreter.hpp"
#include "robsim/base/system.hpp"

namespace robsim::bindings {

namespace {

// Throws the exception that Python has raised, as one that needs no interpreter.
[[noreturn]] void pass_on(py::error_already_set& error) {
  const py::object name = py::getattr(error.value(), "fault", py::none());
  const CaptureFault fault =
      py::isinstance<py::str>(name) ? fault_of(name.cast<std::string>()) : CaptureFault::failed;
  throw PythonCaptureError(fault, error.what(), shared_object(error.value()));
}

std::optional<double> seconds_from(py::handle value) {
  return value.is_none() ? std::optional<double>() : value.cast<double>();
}

// A number of images since the last one.
std::int64_t count_from(py::handle value) {
  const auto count = value.cast<std::int64_t>();
  constexpr std::int64_t most = 1'000'000'000;
  if (count < 0 || count > most) throw py::cast_error();
  return count;
}

// The result of read(), without the pixels.
Captured captured_from(const py::tuple& read) {
  if (read.size() != 2 && read.size() != 5) throw py::cast_error();
  Captured captured;
  captured.arrived = monotonic_now();
  captured.is_complete = !read[0].is_none();
  captured.exposed = seconds_from(read[1]);
  if (read.size() == 5) {
    captured.arrived = read[2].cast<double>();
    captured.passed = count_from(read[3]);
    captured.torn = count_from(read[4]);
  }
  return captured;
}

}  // namespace

void raise_camera_error(const CaptureError& error) {
  const auto* of_python = dynamic_cast<const PythonCaptureError*>(&error);
  if (!of_python) return raise_in_python(error);
  // A copy, as an exception keeps the frames that it passes, and with them the camera that would
  // keep the exception.
  const py::object kept = of_python->raised();
  const py::object raised = py::module_::import("copy").attr("copy")(kept);
  raised.attr("__cause__") = kept.attr("__cause__");
  raised.attr("__traceback__") = kept.attr("__traceback__");
  PyErr_SetObject(py::type::handle_of(raised).ptr(), raised.ptr());
}

py::object PythonCamera::call(const char* method) const {
  return py::handle(camera_.get()).attr(method)();
}

void PythonCamera::open() {
  const py::gil_scoped_acquire interpreter;
  try {
    call("open");
  } catch (py::error_already_set& error) {
    pass_on(error);
  }
}

std::optional<Captured> PythonCamera::next(ImagePool& pool) {
  const py::gil_scoped_acquire interpreter;
  try {
    const py::object read = call("read");
    if (read.is_none()) return std::nullopt;
    const auto parts = read.cast<py::tuple>();
    Captured captured = captured_from(parts);
    if (!captured.is_complete) return captured;
    const ImageView view = image_view(parts[0], "the image of read()");
    const WithoutInterpreter work;
    captured.image = pool.take(view.width, view.height);
    (bgr_ ? copy_bgr : copy)(view, captured.image.writable_view());
    return captured;
  } catch (py::error_already_set& error) {
    pass_on(error);
  } catch (const py::cast_error&) {
    throw CaptureError(CaptureFault::failed,
                       "read() must return None, or a pair (image, time of its exposure)");
  } catch (const py::builtin_exception& error) {
    throw CaptureError(CaptureFault::failed, error.what());
  }
}

void StreamedCamera::open() {
  const py::gil_scoped_acquire interpreter;
  try {
    const int descriptor = call("open").cast<int>();
    const auto name = py::handle(camera()).attr("name").cast<std::string>();
    stream_ = std::make_unique<PixelStream>(descriptor, name);
  } catch (py::error_already_set& error) {
    pass_on(error);
  }
}

std::optional<Captured> StreamedCamera::next(ImagePool& pool) { return stream_->next(pool); }

void StreamedCamera::close() noexcept {
  stream_.reset();
  PythonCamera::close();
}

void StreamedCamera::interrupt() noexcept { call_quietly("interrupt"); }

void PythonCamera::close() noexcept { call_quietly("close"); }

void PythonCamera::call_quietly(const char* method) const noexcept {
  const py::gil_scoped_acquire interpreter;
  try {
    call(method);
  } catch (py::error_already_set& error) {
    error.discard_as_unraisable(method);
  }
}

}  // namespace robsim::bindings
