// The extension _gige: GigE Vision by Aravis.
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
#include "python/signature.hpp"
#include "robsim/lab/capture/gige/gige_camera.hpp"
#include "robsim/lab/capture/gige/gige_vision.hpp"

namespace py = pybind11;
using namespace robsim;
using namespace robsim::bindings;

namespace {

const char* const name = "robsim._gige";

py::dict identity_dict(const GigeIdentity& identity) {
  py::dict values;
  values["address"] = identity.address;
  values["vendor"] = device_text(identity.vendor);
  values["model"] = device_text(identity.model);
  values["serial"] = device_text(identity.serial);
  values["user_name"] = device_text(identity.user_name);
  return values;
}

py::object info_of(const GigeCamera& camera) {
  const std::optional<GigeInfo> info = camera.info();
  if (!info) return py::none();
  py::dict values = identity_dict(info->identity);
  const SensorRegion& region = info->region;
  values["format"] = device_text(info->format);
  values["coding"] = info->coding;
  values["region"] = py::make_tuple(region.left, region.top, region.width, region.height);
  values["fps"] = info->fps;
  values["packet_size"] = info->packet_size;
  values["advice"] = info->advice;
  return values;
}

std::shared_ptr<GigeCamera> make_camera(const std::string& source,
                                        std::optional<std::pair<int, int>> size,
                                        std::optional<std::array<int, 4>> region,
                                        std::optional<double> fps, const std::string& format,
                                        const Wishes& features, int packet_size) {
  GigeCameraOptions options;
  options.source = source;
  options.packet_size = packet_size;
  options.settings.format = format;
  options.settings.size = size;
  if (region) {
    options.settings.region = SensorRegion{(*region)[0], (*region)[1], (*region)[2], (*region)[3]};
  }
  options.settings.fps = fps;
  options.settings.features = wishes_from(features);
  return std::make_shared<GigeCamera>(std::move(options));
}

}  // namespace

PYBIND11_MODULE(_gige, module) {
  module.doc() = "GigE Vision cameras, read by Aravis.";
  py::module_::import("robsim._core");  // which knows the classes that these build on
  translate_capture_errors();
  py::class_<GigeCamera, CaptureDevice, std::shared_ptr<GigeCamera>> camera(
      public_in(module, name), "GigeCamera",
      "A GigE Vision camera, for a grabber. Users take robsim.Camera.");
  camera
      .def(py::init(&make_camera), "source"_a, py::kw_only(), "size"_a, "region"_a, "fps"_a,
           "format"_a, "features"_a, "packet_size"_a)
      .def_property_readonly(
          "info", &info_of,
          "dict or None: its identity and the format of its frames, once it was open.");
  bind_camera(camera);
  module.def(
      "find_cameras",
      [](double seconds) {
        py::list list;
        for (const auto& one : natively([&] { return find_gige_cameras(seconds); })) {
          list.append(identity_dict(one));
        }
        return list;
      },
      "seconds"_a = 1.0);
  module.def("lost_between", &lost_between, "last"_a, "id"_a);
  module.attr("aravis_version") = ARAVIS_VERSION;
  py::delattr(module, "__module__");
}
