// The extension _gige_server, which doubles.py wraps.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <memory>
#include <string>
#include <utility>

#include "gige_server/gige_server.hpp"

namespace py = pybind11;
using namespace robsim;

namespace {

std::unique_ptr<GigeServer> make_server(std::shared_ptr<CaptureDevice> device,
                                        const std::string& serial, std::pair<int, int> size,
                                        double fps) {
  const py::gil_scoped_release others;
  GigeServerOptions options;
  options.serial = serial;
  options.width = size.first;
  options.height = size.second;
  options.fps = fps;
  return std::make_unique<GigeServer>(std::move(device), options);
}

}  // namespace

PYBIND11_MODULE(_gige_server, module) {
  py::module_::import("robsim._core");  // which knows the devices
  py::class_<GigeServer>(module, "GigeServer")
      .def(py::init(&make_server))
      .def_property_readonly("sent_frames", &GigeServer::sent)
      .def_property_readonly("failure", &GigeServer::failure)
      .def("close", &GigeServer::close, py::call_guard<py::gil_scoped_release>());
}
