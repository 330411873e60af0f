#include <pybind11/stl.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "python/interpreter.hpp"
#include "python/numpy.hpp"
#include "python/signature.hpp"
#include "robsim/lab/laboratory/laboratory_camera.hpp"

namespace py = pybind11;
using namespace robsim;
using namespace robsim::bindings;

namespace {

// In a forked process its thread and its locks are nobody's: there it is left alone. The last to
// have it may be the thread of a camera; its world holds objects of the interpreter's.
struct Ended {
  void operator()(Laboratory* laboratory) const {
    if (laboratory->is_elsewhere()) return;
    laboratory->close();
    if (!Py_IsInitialized()) return;
    const py::gil_scoped_acquire interpreter;
    delete laboratory;
  }
};

std::shared_ptr<Laboratory> make_laboratory(const std::shared_ptr<World>& world,
                                            const RobotModel& model,
                                            const std::shared_ptr<ReceivedInput>& input) {
  auto simulated = std::dynamic_pointer_cast<SimulatedWorld>(world);
  if (!simulated) throw py::type_error("world must be a SimulatedWorld");
  if (world->is_interpreted()) throw py::value_error("world must not need the interpreter");
  return {new Laboratory(std::move(simulated), model, input), Ended()};
}

template <std::size_t Width, typename Get>
py::array_t<double> column(const Laboratory::Record& record, const Get& get) {
  py::array_t<double> values({record.ticks.size(), Width});
  double* to = values.mutable_data();
  for (const Laboratory::Tick& tick : record.ticks) {
    for (const double value : get(tick)) *to++ = value;
  }
  return values;
}

using OneNumber = std::array<double, 1>;

py::typing::Dict<py::str, py::object> laboratory_columns(const Laboratory& self) {
  Laboratory::Record record;
  {
    const WithoutInterpreter wait;
    record = self.record();
  }
  using Tick = Laboratory::Tick;
  py::typing::Dict<py::str, py::object> columns;
  columns["first"] = record.first;
  columns["t"] = column<1>(record, [](const Tick& tick) { return OneNumber{tick.time}; });
  columns["pose"] = column<3>(record, [](const Tick& tick) {
    return std::array<double, 3>{tick.pose.x, tick.pose.y, tick.pose.heading};
  });
  columns["last_u"] = column<2>(record, [](const Tick& tick) {
    return std::array<double, 2>{tick.last_u.u1, tick.last_u.u2};
  });
  columns["hidden"] =
      column<1>(record, [](const Tick& tick) { return OneNumber{1.0 * tick.hidden}; });
  columns["shown"] = column<1>(
      record, [](const Tick& tick) { return OneNumber{static_cast<double>(tick.shown)}; });
  return columns;
}

void check_here(const Laboratory& laboratory) {
  if (laboratory.is_elsewhere()) {
    throw std::runtime_error(
        "the laboratory was made in another process, which this one was forked from: make one "
        "here");
  }
}

// A method of a laboratory, which is of use in its own process alone.
template <auto Method, typename... Arguments>
auto here() {
  return [](Laboratory& self, Arguments... arguments) {
    check_here(self);
    const WithoutInterpreter wait;
    return (self.*Method)(arguments...);
  };
}

TimeSpan span_from(const std::pair<double, double>& span) { return {span.first, span.second}; }

void bind_faults(py::module_& module) {
  Class<CameraFaults>(public_in(module, "robsim._core"), "CameraFaults",
                      "What goes wrong with a simulated camera. Users take "
                      "robsim.lab.CameraFaults.")
      .def(py::init([](double late, double lateness, double dropped, double repeated, double torn,
                       std::pair<double, double> stall, std::pair<double, double> unplugged,
                       double drift, double drift_period, std::uint64_t seed) {
             CameraFaults faults;
             faults.late = late;
             faults.lateness = lateness;
             faults.dropped = dropped;
             faults.repeated = repeated;
             faults.torn = torn;
             faults.stall = span_from(stall);
             faults.unplugged = span_from(unplugged);
             faults.drift = drift;
             faults.drift_period = drift_period;
             faults.seed = seed;
             return faults;
           }),
           py::kw_only(), py::arg("late"), py::arg("lateness"), py::arg("dropped"),
           py::arg("repeated"), py::arg("torn"), py::arg("stall"), py::arg("unplugged"),
           py::arg("drift"), py::arg("drift_period"), py::arg("seed"));
}

std::shared_ptr<LaboratoryCamera> make_camera(const std::shared_ptr<Laboratory>& laboratory,
                                              const std::shared_ptr<Scene>& scene,
                                              const std::optional<std::shared_ptr<Warp>>& warp,
                                              const std::optional<std::shared_ptr<Warp>>& top,
                                              const VisualNoise& noise, std::uint64_t noise_seed,
                                              double delay, const CameraFaults& faults) {
  check_here(*laboratory);
  return std::make_shared<LaboratoryCamera>(
      laboratory, scene,
      LaboratoryCameraOptions{warp.value_or(nullptr), noise, noise_seed, delay, faults,
                              top.value_or(nullptr)});
}

}  // namespace

void bind_laboratory(py::module_& module) {
  Class<Laboratory, std::shared_ptr<Laboratory>>(public_in(module, "robsim._core"), "Laboratory",
                                                 "The simulated world in real time. Users take "
                                                 "robsim.lab.SimulatedLab.")
      .def(py::init(&make_laboratory), py::arg("world"), py::arg("model"), py::arg("input"))
      .def("start", here<&Laboratory::start>())
      .def("close",
           [](Laboratory& self) {
             if (self.is_elsewhere()) return;
             const WithoutInterpreter wait;
             self.close();
           })
      .def("stall", here<&Laboratory::stall, double>(), py::arg("seconds"))
      .def("unplug", here<&Laboratory::unplug>())
      .def("plug_in", here<&Laboratory::plug_in>())
      .def("columns",
           [](const Laboratory& self) {
             check_here(self);
             return laboratory_columns(self);
           })
      .def_property_readonly("is_elsewhere", &Laboratory::is_elsewhere,
                             "bool: True in a process forked from its own, where it is of no use.")
      .def_property_readonly("skipped", &Laboratory::skipped,
                             "int: frames that it was too late to draw.");

  bind_faults(module);

  Class<LaboratoryCamera, CaptureDevice, std::shared_ptr<LaboratoryCamera>>(
      public_in(module, "robsim._core"), "LaboratoryCamera",
      "The camera of a laboratory, for a grabber. Users take robsim.lab.SimulatedLab.")
      .def(py::init(&make_camera), py::arg("laboratory"), py::arg("scene"), py::kw_only(),
           py::arg("warp"), py::arg("top"), py::arg("noise"), py::arg("noise_seed"),
           py::arg("delay"), py::arg("faults"));

  Class<RaisedRobot>(public_in(module, "robsim._core"), "RaisedRobot",
                     "A robot's top above the floor, as a camera elsewhere sees it.")
      .def(py::init<std::shared_ptr<Scene>, std::shared_ptr<Warp>>(), py::arg("scene"),
           py::arg("warp"))
      .def(
          "drawn",
          [](RaisedRobot& self, const PixelArray& floor, const ArrayLike& pose) {
            Image image = copy_of(image_view(floor, "floor"));
            self.draw(pose_from(pose, "pose"), image.writable_view());
            return image_array(image);
          },
          py::arg("floor"), py::arg("pose"), "Return a frame of the floor with the robot.");

  public_in(module, "robsim._core")
      .def(
          "view_warp",
          [](const Scene& scene, std::pair<int, int> size, const PlaneMap& plane_map) {
            if (std::min(size.first, size.second) < 1) {
              throw py::value_error("size must be at least 1 x 1 px");
            }
            return std::make_shared<Warp>(view_warp(scene, size.first, size.second, plane_map));
          },
          py::arg("scene"), py::arg("size"), py::arg("plane_map"),
          "Return the warp from a scene to the frames of a camera elsewhere.");
}
