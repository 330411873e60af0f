#pragma once

#include <memory>
#include <string>

#include "python/numpy.hpp"
#include "robsim/capture/capture_device.hpp"

namespace robsim::bindings {

/// A Python object that must be given back while nobody holds the interpreter, in any thread.
using SharedObject = std::shared_ptr<PyObject>;
SharedObject shared_object(py::object object);

/// What a Python camera raised: the exception itself passes on to the reader.
class PythonCaptureError : public CaptureError {
 public:
  PythonCaptureError(CaptureFault fault, const std::string& text, SharedObject raised)
      : CaptureError(fault, text), raised_(std::move(raised)) {}

  py::object raised() const { return py::reinterpret_borrow<py::object>(raised_.get()); }

 private:
  SharedObject raised_;
};

/// The fault of a name, "time_out" of CaptureFault::time_out; `failed` where there is none.
CaptureFault fault_of(const std::string& name);
const char* name_of(CaptureFault fault);

/// A camera in Python, with `open()`, `read()` and `close()`. The interpreter is held for these
/// calls alone; pixels are copied without it.
class PythonCamera : public CaptureDevice {
 public:
  PythonCamera(py::object camera, bool bgr)
      : camera_(shared_object(std::move(camera))), bgr_(bgr) {}

  void open() override;
  std::optional<Captured> next(ImagePool& pool) override;
  void close() noexcept override;

 private:
  py::object call(const char* method) const;

  SharedObject camera_;
  bool bgr_;
};

}  // namespace robsim::bindings
