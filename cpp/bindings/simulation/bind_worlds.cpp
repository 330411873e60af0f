#include <pybind11/stl.h>

#include <algorithm>

#include "python/callbacks.hpp"
#include "python/numpy.hpp"
#include "python/public_names.hpp"
#include "robsim/model/unicycle.hpp"
#include "robsim/simulation/world/external_world.hpp"
#include "robsim/simulation/world/simulated_world.hpp"

namespace py = pybind11;
using namespace robsim;
using namespace robsim::bindings;

namespace {

// The simulated world with Python values in its slots.
class SlottedWorld : public SimulatedWorld, public SlotValues {
 public:
  using SimulatedWorld::SimulatedWorld;

  const RunGuard& loop_guard() const { return guard(); }

  void set_evaluate_model(const py::object& value);

  // Called from work that does not hold the interpreter, too.
  void set_make_scene(const py::object& make, bool makes_at_start) {
    guard().check_idle("a callback");
    slots().makes_scene_at_start = makes_at_start;
    slots().make_scene = [make = py::handle(make)] {
      const py::gil_scoped_acquire interpreter;
      return make().cast<std::shared_ptr<Scene>>();
    };
    values["make_scene"] = make;
  }

  void set_true_model(const py::object& draw) {
    slots().true_model = nullptr;
    if (!draw.is_none()) {
      slots().true_model = [draw = py::handle(draw)](const RobotModel& model) {
        return draw(model).cast<RobotModel>();
      };
    }
    values["true_model"] = draw;
  }
};

void SlottedWorld::set_evaluate_model(const py::object& value) {
  guard().check_idle("a callback");
  if (value.is_none()) {
    slots().evaluate_model = {};
  } else if (py::type::of(value).is(py::type::of<Unicycle>())) {
    slots().evaluate_model = {[](const WorldState& world) {
                                return Unicycle()(world.model, world.pose_1, world.pose_2,
                                                  world.last_u);
                              },
                              false};
  } else {
    slots().evaluate_model = {
        [callback = Callback("evaluate_model", value)](const WorldState& world) {
          const py::object result = callback(world.k, py::cast(world));
          return callback.convert(world.k, [&] { return pose_from(result, "the result"); });
        },
        true};
  }
  values["evaluate_model"] = value;
}

std::shared_ptr<SlottedWorld> make_world(std::pair<int, int> area, std::pair<int, int> resolution,
                                         const std::string& boundary, double robot_radius,
                                         int camera_delay, int motor_delay) {
  WorldOptions options;
  options.area = {
      area.first, area.second,
      choice_from<Boundary>("boundary", boundary,
                            {{"bounce", Boundary::bounce}, {"unlimited", Boundary::unlimited}})};
  options.camera = PlaneMap::scaled(resolution.first, resolution.second, area.first, area.second);
  options.width = resolution.first;
  options.height = resolution.second;
  options.robot_radius = robot_radius;
  options.camera_delay = camera_delay;
  options.motor_delay = motor_delay;
  return std::make_shared<SlottedWorld>(options);
}

Eigen::Matrix3d matrix_from(const py::object& value, const std::string& name) {
  const Doubles rows = doubles_from(value, name, Shape{3, 3}, "an array of shape (3, 3)");
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rows.data());
}

// What a capture shows: a new frame, or one that borrows `out`, written anew.
Frame drawn(SlottedWorld& self, const SimulatedWorld::Capture& capture, const py::object& out) {
  const RunGuard::Look look(self.loop_guard());
  if (out.is_none()) return self.draw(capture);
  const py::object pixels = PyObject_CheckBuffer(out.ptr()) ? py::object(py::array(out)) : out;
  return self.draw_into(capture, writable_view(pixels, "out"), borrowed_image(pixels, "out"));
}

void bind_world_state(py::module_& module) {
  py::class_<WorldState>(public_in(module, "robsim"), "WorldState",
                         "What the callback `evaluate_model` gets.")
      .def_readonly("k", &WorldState::k, "int: number of the step.")
      .def_readonly("t", &WorldState::t, "float: time (s).")
      .def_readonly("dt", &WorldState::dt, "float: sample time (s).")
      .def_property_readonly(
          "pose_1", [](const WorldState& self) { return bindings::to_array(self.pose_1); },
          "array (3,): the pose of step k-1: x, y (work-area px), heading (rad).")
      .def_property_readonly(
          "pose_2", [](const WorldState& self) { return bindings::to_array(self.pose_2); },
          "array (3,): the pose of step k-2.")
      .def_property_readonly(
          "last_u", [](const WorldState& self) { return to_array(self.last_u); },
          "array (2,): what the motors got since step k-1 (V): with noise and delay, if there are "
          "any.")
      .def_property_readonly(
          "model", [](const WorldState& self) { return self.model; },
          "RobotModel: the one that this world follows.")
      .def("__repr__", [](const WorldState& self) {
        return "<WorldState of step " + std::to_string(self.k) + ">";
      });
}

void bind_simulated_world(py::module_& module) {
  py::class_<SlottedWorld, World, std::shared_ptr<SlottedWorld>>(
      public_in(module, "robsim._core"), "SimulatedWorld",
      "The simulated world half. Users take robsim.Simulation.",
      py::custom_type_setup(&collect_garbage<SlottedWorld>))
      .def(py::init(&make_world), py::kw_only(), py::arg("area"), py::arg("resolution"),
           py::arg("boundary"), py::arg("robot_radius"), py::arg("camera_delay"),
           py::arg("motor_delay"))
      .def("set_evaluate_model", &SlottedWorld::set_evaluate_model, py::arg("value"))
      .def("set_make_scene", &SlottedWorld::set_make_scene, py::arg("make"),
           py::arg("makes_at_start"))
      .def("set_true_model", &SlottedWorld::set_true_model, py::arg("draw"))
      .def(
          "set_start",
          [](SlottedWorld& self, const py::object& start) {
            self.set_start(pose_from(start, "start"));
          },
          py::arg("start"))
      .def("set_noise", &SlottedWorld::set_noise, py::arg("noise"))
      .def("set_dropout", &SlottedWorld::set_dropout, py::arg("probability"), py::arg("steps"))
      .def(
          "set_disturbance",
          [](SlottedWorld& self, const py::object& pose_factor,
             const std::array<double, 2>& input_sigma) {
            self.set_disturbance(matrix_from(pose_factor, "pose_factor"), input_sigma);
          },
          py::arg("pose_factor"), py::arg("input_sigma"))
      .def("set_seeds", &SlottedWorld::set_seeds, py::kw_only(), py::arg("noise"),
           py::arg("dropout"), py::arg("disturbance"))
      .def_property_readonly("model", [](const SlottedWorld& self) { return self.model(); })
      .def_property_readonly(
          "scene",
          [](const SlottedWorld& self) { return std::const_pointer_cast<Scene>(self.scene()); },
          "Scene or None: what the camera looks at; None if nobody has looked yet.")
      .def(
          "draw_newest",
          [](SlottedWorld& self, const py::object& out) {
            const SimulatedWorld::Capture* capture = self.newest_capture();
            if (!capture) throw std::runtime_error("no frame has come yet in this step");
            return drawn(self, *capture, out);
          },
          py::arg("out") = py::none(), "Return the newest frame, or write it to `out`.")
      .def(
          "draw",
          [](SlottedWorld& self, std::int64_t k, const py::object& pose,
             const std::array<double, 2>& view, bool hidden, const std::array<double, 2>& noise,
             const py::object& out) {
            Truth truth;
            truth.pose = pose_from(pose, "pose");
            truth.view = {view[0], view[1]};
            truth.hidden = hidden;
            truth.gaussian_noise = noise[0];
            truth.uniform_noise = noise[1];
            return drawn(self, self.capture_of(k, truth), out);
          },
          py::arg("k"), py::arg("pose"), py::arg("view"), py::arg("hidden"), py::arg("noise"),
          py::arg("out") = py::none(),
          "Return the frame of an earlier step, or write it to `out`.");
}

// Frames from an iterable of Python's, inputs to a callable.
class PythonSource : public ExternalWorld, public SlotValues {
 public:
  PythonSource(const py::object& take, const py::object& send, const py::object& stop)
      : ExternalWorld(source(take, send, stop)) {
    values = {{"take", take}, {"send", send}, {"stop", stop}};
  }

 private:
  static ExternalSource source(const py::object& take, const py::object& send,
                               const py::object& stop);
};

Arrival arrival_of(const py::object& taken, Arrived& arrived, std::int64_t k) {
  if (py::isinstance<Arrival>(taken)) return taken.cast<Arrival>();
  if (py::isinstance<Frame>(taken)) {
    arrived.frame = taken.cast<Frame>();
  } else if (py::isinstance<Arrived>(taken)) {
    arrived = taken.cast<Arrived>();
  } else if (!taken.is_none()) {
    throw py::type_error("frames must give Frame or Observation objects, or None, got " +
                         describe(taken) + " at step " + std::to_string(k));
  }
  return Arrival::step;
}

// Stops the robot even where a Ctrl-C comes in between: that is put off.
std::optional<Input> stopped(const py::handle& stop) {
  bool is_interrupted = false;
  py::object u = py::none();
  for (int attempt = 0; attempt < 3; ++attempt) {
    try {
      u = stop();
      break;
    } catch (py::error_already_set& error) {
      if (error.matches(PyExc_KeyboardInterrupt)) {
        is_interrupted = true;
      } else {
        error.discard_as_unraisable("stop");
      }
    }
  }
  std::optional<Input> sent;
  if (!u.is_none()) sent = input_from(u, "stop_input");  // finite: Motors has seen to that
  if (is_interrupted) PyErr_SetInterrupt();
  return sent;
}

ExternalSource PythonSource::source(const py::object& take, const py::object& send,
                                    const py::object& stop) {
  ExternalSource source;
  source.take = [callback = Callback("frames", take, "frames")](std::int64_t k, Arrived& arrived) {
    return arrival_of(callback(k, py::int_(k)), arrived, k);
  };
  if (!send.is_none()) {
    source.send = [callback = Callback("send", send, "send")](std::int64_t k, const Input& u) {
      callback(k, to_array(u));
    };
  }
  if (!stop.is_none()) source.stop = [stop = py::handle(stop)] { return stopped(stop); };
  return source;
}

void bind_external_world(py::module_& module) {
  py::enum_<Arrival>(public_in(module, "robsim._core"), "Arrival",
                     "What a source of frames may say in place of a frame.")
      .value("NOTHING_YET", Arrival::nothing_yet)
      .value("END", Arrival::end);

  py::class_<PythonSource, World, std::shared_ptr<PythonSource>>(
      public_in(module, "robsim._core"), "ExternalWorld",
      "The world half outside. Users take robsim.Experiment.",
      py::custom_type_setup(&collect_garbage<PythonSource>))
      .def(py::init<const py::object&, const py::object&, const py::object&>(), py::kw_only(),
           py::arg("take"), py::arg("send"), py::arg("stop"));
}

}  // namespace

void bind_worlds(py::module_& module) {
  bind_world_state(module);
  py::class_<World, std::shared_ptr<World>>(public_in(module, "robsim._core"), "World",
                                            "A world half, as the loop sees it.");
  bind_simulated_world(module);
  bind_external_world(module);
}
