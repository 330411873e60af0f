// The extension _bus_server, which doubles.py wraps.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "bus_server/bus_server.hpp"

namespace py = pybind11;
using namespace robsim;

namespace {

using Camera = std::tuple<std::pair<int, int>, double, std::vector<std::string>, std::string, bool>;

std::unique_ptr<BusServer> make_bus(const std::string& path, const std::vector<Camera>& cameras,
                                    std::vector<std::shared_ptr<CaptureDevice>> devices,
                                    bool card_is_fast) {
  std::vector<BusCameraOptions> options;
  for (const auto& [size, fps, codings, filter, is_fast] : cameras) {
    options.push_back({size.first, size.second, fps, codings, filter, is_fast});
  }
  return std::make_unique<BusServer>(path, options, std::move(devices), card_is_fast);
}

}  // namespace

PYBIND11_MODULE(_bus_server, module) {
  py::module_::import("robsim._core");  // which knows the devices
  py::class_<BusServer>(module, "BusServer")
      .def(py::init(&make_bus))
      .def("close", &BusServer::close, py::call_guard<py::gil_scoped_release>())
      .def("guid", &BusServer::guid_of, py::arg("camera") = 0)
      .def("is_sending", &BusServer::is_sending, py::arg("camera") = 0)
      .def("lost_frames", &BusServer::lost_frames, py::arg("camera") = 0)
      .def("unplug", &BusServer::unplug, py::arg("camera") = 0)
      .def("plug_in", &BusServer::plug_in, py::arg("camera") = 0)
      .def("stall", &BusServer::stall, py::arg("seconds"), py::arg("camera") = 0)
      .def("deny", &BusServer::deny, py::arg("camera") = 0, py::kw_only(), py::arg("denied") = true)
      .def("simplify", &BusServer::simplify, py::arg("camera") = 0)
      .def("shorten", &BusServer::shorten, py::arg("camera") = 0, py::kw_only(),
           py::arg("shortened") = true)
      .def("reset", &BusServer::reset, py::kw_only(), py::arg("power_fails") = false)
      .def("refuse", &BusServer::refuse, py::kw_only(), py::arg("channels") = false,
           py::arg("bandwidth") = false);
}
