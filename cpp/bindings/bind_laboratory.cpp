#include <algorithm>

#include "python/interpreter.hpp"
#include "python/signature.hpp"
#include "robsim/lab/laboratory/laboratory_camera.hpp"

using namespace robsim;
using namespace robsim::bindings;

namespace {

// In a forked process its thread does not exist and its locks have no owner: it is not touched
// there. Its last owner may be the thread of a camera; its world holds objects of the interpreter.
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

using Ticks = py::typing::Tuple<std::int64_t, py::array_t<double>>;

// The first tick, and for each the time, x, y, heading, u1, u2, hidden, shown.
Ticks ticks_of(const Laboratory& self) {
  check_here(self);
  const Laboratory::Record record = natively([&] { return self.record(); });
  py::array_t<double> rows({record.ticks.size(), std::size_t{8}});
  double* to = rows.mutable_data();
  for (const Laboratory::Tick& tick : record.ticks) {
    for (const double value :
         {tick.time, tick.pose.x, tick.pose.y, tick.pose.heading, tick.last_u.u1, tick.last_u.u2,
          1.0 * tick.hidden, static_cast<double>(tick.shown)}) {
      *to++ = value;
    }
  }
  return Ticks(py::make_tuple(record.first, rows));
}

using Span = std::pair<double, double>;  // start and duration

void bind_faults(py::module_& module) {
  Class<CameraFaults>(public_in(module, "robsim._core"), "CameraFaults",
                      "Faults of a simulated camera. Users take robsim.lab.CameraFaults.")
      .def(py::init([](double late, double lateness, double dropped, double repeated, double torn,
                       Span stall, Span unplugged, double drift, double drift_period,
                       std::uint64_t seed) {
             return CameraFaults{late,
                                 dropped,
                                 repeated,
                                 torn,
                                 lateness,
                                 {stall.first, stall.second},
                                 {unplugged.first, unplugged.second},
                                 drift,
                                 drift_period,
                                 seed};
           }),
           py::kw_only(), "late"_a, "lateness"_a, "dropped"_a, "repeated"_a, "torn"_a, "stall"_a,
           "unplugged"_a, "drift"_a, "drift_period"_a, "seed"_a);
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
      .def(py::init(&make_laboratory), "world"_a, "model"_a, "input"_a)
      .def("start", here<&Laboratory::start>())
      .def("close",
           [](Laboratory& self) {
             if (self.is_elsewhere()) return;
             const WithoutInterpreter wait;
             self.close();
           })
      .def("stall", here<&Laboratory::stall, double>(), "seconds"_a)
      .def("unplug", here<&Laboratory::unplug>())
      .def("plug_in", here<&Laboratory::plug_in>())
      .def("ticks", &ticks_of)
      .def_property_readonly("is_elsewhere", &Laboratory::is_elsewhere,
                             "bool: True in a forked process, where it does not work.")
      .def_property_readonly("skipped", &Laboratory::skipped,
                             "int: frames skipped because they were late.");

  bind_faults(module);

  Class<LaboratoryCamera, CaptureDevice, std::shared_ptr<LaboratoryCamera>>(
      public_in(module, "robsim._core"), "LaboratoryCamera",
      "The camera of a laboratory, for a grabber. Users take robsim.lab.SimulatedLab.")
      .def(py::init(&make_camera), "laboratory"_a, "scene"_a, py::kw_only(), "warp"_a, "top"_a,
           "noise"_a, "noise_seed"_a, "delay"_a, "faults"_a);

  Class<RaisedRobot>(public_in(module, "robsim._core"), "RaisedRobot",
                     "A robot's top above the floor, as seen by an oblique camera.")
      .def(py::init<std::shared_ptr<Scene>, std::shared_ptr<Warp>>(), "scene"_a, "warp"_a)
      .def(
          "drawn",
          [](RaisedRobot& self, const ImageView& floor, const Pose& pose) {
            Image image = copy_of(floor);
            self.draw(pose, image.writable_view());
            return image;
          },
          "floor"_a, "pose"_a, "Return a frame of the floor with the robot.");

  public_in(module, "robsim._core")
      .def(
          "view_warp",
          [](const Scene& scene, std::pair<int, int> size, const PlaneMap& plane_map) {
            if (std::min(size.first, size.second) < 1) {
              throw py::value_error("size must be at least 1 x 1 px");
            }
            return std::make_shared<Warp>(view_warp(scene, size.first, size.second, plane_map));
          },
          "scene"_a, "size"_a, "plane_map"_a,
          "Return the warp from a scene to the frames of an oblique camera.");
}
