// The extension of cameras on FireWire, which needs libdc1394.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "capture/capture_errors.hpp"
#include "capture/native_camera.hpp"
#include "python/interpreter.hpp"
#include "robsim/lab/capture/firewire/fire_wire_camera.hpp"

namespace py = pybind11;
using namespace robsim;
using namespace robsim::bindings;
using fire_wire::CameraOptions;
using fire_wire::FireWireCamera;

namespace {

std::shared_ptr<FireWireCamera> make_camera(const std::string& choice,
                                            std::optional<std::pair<int, int>> size,
                                            std::optional<std::array<int, 4>> region,
                                            std::optional<double> fps, const std::string& coding,
                                            const Wishes& features) {
  return std::make_shared<FireWireCamera>(
      CameraOptions{choice, {size, region, fps, coding}, wishes_from(features)});
}

py::dict video_of(const FireWireCamera& self) {
  const auto video = self.video();
  py::dict found;
  if (!video) return found;
  found["size"] = py::make_tuple(video->width, video->height);
  found["region"] =
      video->has_region()
          ? py::object(py::make_tuple(video->left, video->top, video->width, video->height))
          : py::none();
  found["fps"] = video->fps;
  found["speed"] = 100 << (video->speed - DC1394_ISO_SPEED_100);  // Mbit/s
  found["coding"] = video->format->coding;
  return found;
}

py::list cameras() {
  py::list list;
  for (const auto& camera : natively([] { return fire_wire::find_cameras(); })) {
    list.append(py::make_tuple(camera.guid, device_text(camera.vendor), device_text(camera.model)));
  }
  return list;
}

}  // namespace

PYBIND11_MODULE(_firewire, module) {
  module.doc() = "Cameras on FireWire, by libdc1394. Users take robsim.Camera(\"firewire://\").";
  py::module_::import("robsim._core");  // has CaptureDevice, and makes errors of CaptureError
  translate_capture_errors();
  py::class_<FireWireCamera, CaptureDevice, std::shared_ptr<FireWireCamera>> camera(
      module, "FireWireCamera", "A camera for a grabber. Users take robsim.Camera.");
  camera
      .def(py::init(&make_camera), py::arg("choice"), py::kw_only(), py::arg("size"),
           py::arg("region"), py::arg("fps"), py::arg("coding"), py::arg("features"))
      .def_property_readonly("video", &video_of,
                             "dict: format of its frames; empty before it is open.")
      .def_property_readonly("guid", &FireWireCamera::guid, "str: its number, 16 digits.")
      .def_property_readonly("restarts", &FireWireCamera::restarts, "int: number of restarts.");
  bind_camera(camera);
  module.def("cameras", &cameras, "Return (guid, vendor, model) of all cameras on the bus.");
  module.def(
      "nodes",
      [] {
        const fire_wire::Nodes nodes = fire_wire::nodes();
        return std::pair(nodes.readable, nodes.denied);
      },
      "Return the device nodes of FireWire: those that can be read, those that must not.");
}
