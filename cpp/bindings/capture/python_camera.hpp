#pragma once

#include "python/numpy.hpp"
#include "robsim/lab/capture/capture_device.hpp"
#include "robsim/lab/capture/pixel_stream.hpp"

namespace robsim::bindings {

/// An exception of a Python camera, which itself passes on to the reader.
class PythonCaptureError : public CaptureError {
 public:
  PythonCaptureError(CaptureFault fault, const std::string& text, SharedObject raised)
      : CaptureError(fault, text), raised_(std::move(raised)) {}

  py::object raised() const { return py::reinterpret_borrow<py::object>(raised_.get()); }

 private:
  SharedObject raised_;
};

/// Raises the exception of a Python camera again, or the error of robsim.lab that a fault stands
/// for.
void raise_camera_error(const CaptureError& error);

/// A camera in Python, with `open()`, `read()` and `close()`. The interpreter is held for these
/// calls only, not for copying pixels.
class PythonCamera : public CaptureDevice {
 public:
  PythonCamera(py::object camera, bool bgr)
      : camera_(shared_object(std::move(camera))), bgr_(bgr) {}

  void open() override;
  std::optional<Captured> next(ImagePool& pool) override;
  void close() noexcept override;

 private:
  SharedObject camera_;
  bool bgr_;

 protected:
  py::object call(const char* method) const;
  void call_quietly(const char* method) const noexcept;
  PyObject* camera() const { return camera_.get(); }
};

/// A camera in another process. `open()` of its object in Python returns the descriptor of a socket
/// that frames come from; they are read without the interpreter. `interrupt()` ends `open()`.
class StreamedCamera : public PythonCamera {
 public:
  explicit StreamedCamera(py::object camera) : PythonCamera(std::move(camera), true) {}

  void open() override;
  std::optional<Captured> next(ImagePool& pool) override;
  void interrupt() noexcept override;
  void close() noexcept override;

 private:
  std::unique_ptr<PixelStream> stream_;
};

}  // namespace robsim::bindings
