#include <algorithm>
#include <cmath>

#include "capture/python_camera.hpp"
#include "python/callbacks.hpp"
#include "python/interpreter.hpp"
#include "python/values.hpp"
#include "robsim/lab/live_ends.hpp"
#include "robsim/model/motion.hpp"
#include "robsim/simulation/seam/thread_guard.hpp"
#include "robsim/simulation/world/external_world.hpp"
#include "robsim/simulation/world/simulated_world.hpp"

using namespace robsim;
using namespace robsim::bindings;

template <>
constexpr Choices<Boundary> robsim::bindings::choices<Boundary> = {
    {"bounce", Boundary::bounce}, {"unlimited", Boundary::unlimited}};

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
    forget_scene();
  }

  void set_true_model(const py::object& draw) {
    guard().check_idle("the model of the world");
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
                                         Boundary boundary) {
  WorldOptions options;
  options.area = {area.first, area.second, boundary};
  options.camera = PlaneMap::scaled(resolution.first, resolution.second, area.first, area.second);
  options.width = resolution.first;
  options.height = resolution.second;
  return std::make_shared<SlottedWorld>(options);
}

// The frame of a step: a new one, or one that borrows `out`.
Frame drawn(SlottedWorld& self, const Truth& captured, const std::optional<PixelArray>& out) {
  if (!out) return self.draw(captured);
  const bool is_buffer = PyObject_CheckBuffer(out->ptr());
  const py::object pixels = is_buffer ? py::object(py::array(*out)) : py::object(*out);
  Image image = writable_image(pixels, "out");
  const WorldOptions& options = self.options();
  if (image.width() != options.width || image.height() != options.height) {
    throw py::value_error("out must have the size of the frames, " + std::to_string(options.width) +
                          " x " + std::to_string(options.height) + " px, got " + describe(*out));
  }
  Renderer::Canvas canvas{image, image.box(), {}};
  return self.draw(captured, &canvas);
}

Frame draw_newest(SlottedWorld& self, const std::optional<PixelArray>& out) {
  const RunGuard::Look look(self.loop_guard());
  if (const Truth* captured = self.newest_captured()) return drawn(self, *captured, out);
  throw std::runtime_error("no frame has come yet in this step");
}

// The other arguments are a row of the trace.
Frame draw(SlottedWorld& self, std::int64_t k, const Pose& pose_true,
           const std::array<double, 2>& view, const std::array<double, 1>& hidden,
           const std::array<double, 2>& noise, const std::optional<PixelArray>& out) {
  const RunGuard::Look look(self.loop_guard());
  Truth captured;
  captured.k = k;
  captured.pose = pose_true;
  captured.view = {view[0], view[1]};
  captured.hidden = hidden[0] > 0;
  captured.noise = noise;
  return drawn(self, captured, out);
}

void set_frame_memory(SlottedWorld& self, const std::vector<py::object>& arrays) {
  std::vector<Image> images;
  for (const py::object& array : arrays) images.push_back(writable_image(array, "images"));
  self.set_frame_memory(images);
}

WorldState make_world_state(const Pose& pose_1, const Pose& pose_2, const Input& last_u,
                            const std::optional<RobotModel>& given_model, std::int64_t k,
                            std::optional<double> t, std::optional<double> dt) {
  check_step_number(k);
  const RobotModel model = given_model.value_or(RobotModel());
  WorldState world{k, 0, dt.value_or(model.dt()), pose_1, pose_2, last_u, model};
  world.t = t.value_or(static_cast<double>(k) * world.dt);
  if (!std::isfinite(world.t)) throw py::value_error("t must be finite (s)");
  if (!(world.dt > 0 && std::isfinite(world.dt))) throw py::value_error("dt must be above 0 s");
  return world;
}

void bind_world_state(py::module_& module) {
  Class<WorldState> world(public_in(module, "robsim.simulation"), "WorldState", R"(
The argument of the callback `evaluate_model`. A state that you create yourself can test a callback
without a simulation.

Parameters
----------
pose_1, pose_2 : array (3,)
    The poses of steps k-1 and k-2: x, y (work-area px), heading (rad).
last_u : array (2,)
    Mean input of the motors since step k-1 (V).
model : RobotModel, optional
    The model that this world follows. Default: the default robot's.
k : int
    Number of the step.
t, dt : float, optional
    Time and sample time (s). Default: k dt, and the dt of the model.

Examples
--------
>>> world = robsim.simulation.WorldState((601, 500, 0), (600, 500, 0), last_u=(0, 0))
>>> robsim.Unicycle()(world).round(2)
array([601.94, 500.  ,   0.  ])
)");
  const Fields fields(
      &make_world_state,
      Field("pose_1", &WorldState::pose_1,
            "array (3,): the pose of step k-1: x, y (work-area px), heading (rad)."),
      Field("pose_2", &WorldState::pose_2, "array (3,): the pose of step k-2."),
      Field("last_u", &WorldState::last_u,
            "array (2,): mean input of the motors since step k-1 (V), with noise and delay if "
            "enabled."),
      Field("model", &WorldState::model, "RobotModel: the model of this world.", std::nullopt),
      by_name, Field("k", &WorldState::k, "int: number of the step.", 1),
      Field("t", &WorldState::t, "float: time (s).", std::nullopt),
      Field("dt", &WorldState::dt, "float: sample time (s).", std::nullopt));
  define_value(world, fields);
  define_repr(world, "<WorldState of step {0.k}>");
}

void set_option(SlottedWorld& self, const std::string& name, const py::handle& value) {
  WorldOptions::each([&](const char* known, auto member) {
    using Value = std::decay_t<decltype(self.options().*member)>;
    if (name == known) self.set(member, value.cast<Value>());
  });
}

std::vector<std::string> option_names() {
  std::vector<std::string> names;
  WorldOptions::each([&](const char* name, auto) { names.push_back(name); });
  return names;
}

void bind_simulated_world(py::module_& module) {
  Class<SlottedWorld, World, std::shared_ptr<SlottedWorld>>(
      public_in(module, "robsim._core"), "SimulatedWorld",
      "The simulated world half. Users take robsim.Simulation.",
      py::custom_type_setup(&collect_garbage<SlottedWorld>))
      .def(py::init(&make_world), py::kw_only(), "area"_a, "resolution"_a, "boundary"_a)
      .def(
          "option_names", [](const SlottedWorld&) { return option_names(); },
          "Return the names for `set_option`.")
      .def("set_option", &set_option, "name"_a, "value"_a)
      .def("set_evaluate_model", &SlottedWorld::set_evaluate_model, "value"_a)
      .def("set_make_scene", &SlottedWorld::set_make_scene, "make"_a, "makes_at_start"_a)
      .def("set_true_model", &SlottedWorld::set_true_model, "draw"_a)
      .def("set_start", &SlottedWorld::set_start, "start"_a)
      .def("set_dropout", &SlottedWorld::set_dropout, "probability"_a, "steps"_a)
      .def("set_disturbance", &SlottedWorld::set_disturbance, "pose_factor"_a, "input_sigma"_a)
      .def("set_seeds", &SlottedWorld::set_seeds, py::kw_only(), "noise"_a, "dropout"_a,
           "disturbance"_a)
      .def(
          "set_noise_keys",
          [](SlottedWorld& self, const py::array_t<std::uint64_t>& keys) {
            self.set_noise_keys({keys.data(), keys.data() + keys.size()});
          },
          "keys"_a,
          "Draw the noise of each frame from a separate key, array (steps,) of uint64; empty: no "
          "longer.")
      .def("set_frame_memory", &set_frame_memory, "images"_a,
           "Draw the newest frames on one of these arrays (H, W, 3), even if it is in use.")
      .def_property_readonly(
          "model", [](const SlottedWorld& self) { return self.model(); },
          "RobotModel or None: the model that the robot follows; None before the start.")
      .def_property_readonly(
          "pose",
          [](const SlottedWorld& self) {
            const RunGuard::Look look(self.loop_guard());
            return self.truth()->pose;
          },
          "array (3,): pose of the robot: x, y (work-area px), heading (rad).")
      .def_property_readonly(
          "scene",
          [](const SlottedWorld& self) {
            const RunGuard::Look look(self.loop_guard());
            return std::const_pointer_cast<Scene>(self.scene());
          },
          "Scene or None: the camera's scene; None before its first use.")
      .def("draw_newest", &draw_newest, "out"_a = py::none(),
           "Return the newest frame, or write it to `out`.")
      .def("draw", &draw, "k"_a, "pose_true"_a, "view"_a = std::array<double, 2>{},
           "hidden"_a = std::array<double, 1>{}, "noise"_a = std::array<double, 2>{},
           "out"_a = py::none(), "Return the frame of an earlier step, or write it to `out`.");
}

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
std::optional<Input> stopped(const py::handle& motors) {
  bool is_interrupted = false;
  std::optional<Input> sent;
  for (int attempt = 0; attempt < 3; ++attempt) {
    try {
      const py::object u = motors.attr("stop")();
      if (!u.is_none()) sent = input_from(u, "stop_input");
      break;
    } catch (py::error_already_set& error) {
      is_interrupted = is_interrupted || error.matches(PyExc_KeyboardInterrupt);
    }
  }
  if (is_interrupted) PyErr_SetInterrupt();
  return sent;
}

// In the watchdog's thread.
void halted(const py::handle& motors) {
  const py::gil_scoped_acquire interpreter;
  try {
    motors.attr("halt")();
  } catch (py::error_already_set& error) {
    error.discard_as_unraisable("halt");
  }
}

FrameSource source_of(const py::object& frames) {
  const Callback take("frames", frames, "frames");
  if (!py::isinstance<Grabber>(frames)) {
    return {[take](std::int64_t k, Arrived& arrived) {
      return arrival_of(take(k, py::int_(k)), arrived, k);
    }};
  }
  FrameSource camera = frames_of(frames.cast<std::shared_ptr<Grabber>>());
  camera.take = [take, next = camera.take](std::int64_t k, Arrived& arrived) {
    try {
      return next(k, arrived);
    } catch (const CaptureError& error) {
      const py::gil_scoped_acquire interpreter;
      raise_camera_error(error);
      take.fail(k);
    }
  };
  return camera;
}

InputSink sink_of(const py::object& motors) {
  if (motors.is_none()) return {};
  if (py::isinstance<MotorLink>(motors)) {
    return inputs_to(motors.cast<std::shared_ptr<MotorLink>>());
  }
  InputSink sink;
  sink.send = [send = Callback("send", motors, "send")](std::int64_t k, const Input& u) {
    send(k, to_array(u));
    return std::optional<double>();
  };
  sink.stop = [motors = py::handle(motors)] { return stopped(motors); };
  if (motors.attr("can_halt").cast<bool>()) {
    sink.halt = [motors = py::handle(motors)] { halted(motors); };
  }
  return sink;
}

// Frames from a camera or a callable, inputs to a link or an object of Python's.
class PythonSource : public ExternalWorld, public SlotValues {
 public:
  PythonSource(const py::object& frames, const py::object& motors, double frame_timeout,
               const std::optional<Limits>& limits, double longest_timeout)
      : ExternalWorld(source_of(frames), sink_of(motors), frame_timeout, limits, longest_timeout) {
    values = {{"frames", frames}, {"motors", motors}};
  }
  ~PythonSource() override { close(); }
};

void bind_external_world(py::module_& module) {
  py::delattr(py::enum_<Arrival>(public_in(module, "robsim._core"), "Arrival",
                                 "An answer of a source of frames instead of a frame.")
                  .value("NOTHING_YET", Arrival::nothing_yet)
                  .value("END", Arrival::end),
              "__init__");  // it complains in pybind11's words

  Class<PythonSource, World, std::shared_ptr<PythonSource>>(
      public_in(module, "robsim._core"), "ExternalWorld",
      "The external world half. Users take robsim.Experiment.",
      py::custom_type_setup(&collect_garbage<PythonSource>))
      .def(py::init<const py::object&, const py::object&, double, const std::optional<Limits>&,
                    double>(),
           py::kw_only(), "frames"_a, "motors"_a, "frame_timeout"_a, "limits"_a,
           "longest_timeout"_a);
}

}  // namespace

void bind_simulated_worlds(py::module_& module) {
  bind_world_state(module);
  Class<World, std::shared_ptr<World>>(public_in(module, "robsim._core"), "World",
                                       "A world half, for the loop.");
  bind_simulated_world(module);
  bind_external_world(module);
}
