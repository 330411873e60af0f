#include <pybind11/stl.h>

#include <chrono>
#include <thread>

#include "python/callbacks.hpp"
#include "python/numpy.hpp"
#include "python/public_names.hpp"
#include "robsim/simulation/simulation.hpp"

namespace py = pybind11;
using namespace robsim;
using namespace robsim::bindings;

namespace {

bool is_finalizing() {
#if PY_VERSION_HEX >= 0x030D0000
  return Py_IsFinalizing() != 0;
#else
  return _Py_IsFinalizing() != 0;
#endif
}

// The interpreter as the loop sees it: the GIL, signals, and a progress callback.
class PythonInterpreter : public Interpreter {
 public:
  explicit PythonInterpreter(py::object progress) : progress_(std::move(progress)) {}

  void release() override { state_ = PyEval_SaveThread(); }
  void acquire() override {
    // A daemon thread that comes back while Python ends would be torn out of this run.
    while (is_finalizing()) std::this_thread::sleep_for(std::chrono::hours(1));
    PyEval_RestoreThread(state_);
  }

  void between_steps(std::int64_t done) override {
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (!progress_.is_none()) progress_(done);
  }

 private:
  py::object progress_;
  PyThreadState* state_ = nullptr;
};

std::unique_ptr<SlottedSimulation> make_simulation(
    std::pair<int, int> area, const std::string& boundary, double robot_radius,
    const py::object& start, const VisualNoise& noise, const std::vector<ColorClass>& colors,
    const MarkerLayout& markers, std::optional<int> smoothing, const std::string& identify_from,
    std::uint64_t controller_seed, std::uint64_t noise_seed, double dropout, int dropout_length,
    std::uint64_t dropout_seed) {
  SimulationOptions options;
  options.area = {
      area.first, area.second,
      choice_from<Boundary>("boundary", boundary,
                            {{"bounce", Boundary::bounce}, {"unlimited", Boundary::unlimited}})};
  options.robot_radius = robot_radius;
  options.start = pose_from(start, "start");
  options.noise = noise;
  options.colors = colors;
  options.markers = markers;
  options.smoothing = smoothing;
  options.identify_from = choice_from<IdentifyFrom>("identify_from", identify_from,
                                                    {{"truth", IdentifyFrom::truth},
                                                     {"measurement", IdentifyFrom::measurement},
                                                     {"estimate", IdentifyFrom::estimate}});
  options.controller_seed = controller_seed;
  options.noise_seed = noise_seed;
  options.dropout = {dropout, dropout_length, dropout_seed};
  auto simulation = std::make_unique<SlottedSimulation>(options, Stages());
  for (const char* slot : {"define_model", "init_parameter_estimator", "control"}) {
    simulation->set_stage(slot, py::none());
  }
  return simulation;
}

// Lets Python's garbage collector look into the slots.
void collect_garbage(PyHeapTypeObject* heap_type) {
  PyTypeObject& type = heap_type->ht_type;
  type.tp_flags |= Py_TPFLAGS_HAVE_GC;
  type.tp_traverse = [](PyObject* self, visitproc visit, void* arg) {
    Py_VISIT(Py_TYPE(self));
    if (!py::detail::is_holder_constructed(self)) return 0;
    for (const auto& slot : py::cast<SlottedSimulation&>(py::handle(self)).values) {
      Py_VISIT(slot.second.ptr());
    }
    return 0;
  };
  type.tp_clear = [](PyObject* self) {
    if (py::detail::is_holder_constructed(self)) {
      py::cast<SlottedSimulation&>(py::handle(self)).values.clear();
    }
    return 0;
  };
}

// Views of the rows recorded by now; they stay what they are while the run goes on.
using Columns = py::typing::Dict<py::str, py::array_t<double>>;

Columns columns_of(const SlottedSimulation& self) {
  Columns columns;
  const Trace::Snapshot trace = self.trace().snapshot();
  const py::ssize_t rows = trace.rows;
  for (const Trace::Column& column : trace.columns) {
    const auto width = static_cast<py::ssize_t>(column.width());
    auto* memory = new Trace::Memory(column.memory());
    const py::capsule owner(memory, [](void* p) { delete static_cast<Trace::Memory*>(p); });
    py::array_t<double> view({rows, width}, (*memory)->data(), owner);
    view.attr("setflags")(py::arg("write") = false);
    columns[column.name().c_str()] = view;
  }
  return columns;
}

// A step may be looked at unless another thread is just filling it.
const Step& readable(const Step& step) {
  if (const Simulation* source = step.source) source->check_thread();
  return step;
}

Simulation& source_of(const Step& step, const char* what) {
  if (Simulation* source = step.source) return *source;
  throw std::runtime_error("the " + std::string(what) + " of step " + std::to_string(step.k) +
                           " was not kept: ask for step." + what + " during the step");
}

const Frame& frame_of(const Step& step) {
  return readable(step).frame ? *step.frame : source_of(step, "frame").frame();
}

const BlobsByColor& blobs_of(const Step& step) {
  return readable(step).blobs ? *step.blobs : source_of(step, "blobs").blobs();
}

py::array_t<double> input_of(const Step& step) {
  if (readable(step).u) return to_array(*step.u);
  throw std::runtime_error("step.u, the input of step " + std::to_string(step.k) +
                           ", is not decided yet: the controller comes last. The input of the "
                           "step before is step.last_u");
}

void bind_records(py::module_& module) {
  py::class_<Estimate>(public_in(module, "robsim"), "Estimate", R"(
What a state estimator makes of a step.

Parameters
----------
pose : array (3,)
    x, y (work-area px), heading (rad).
covariance : array (3, 3)
    Its covariance.
state : array (n,), optional
    Any further state, n the same at every step.
)")
      .def(py::init([](const py::object& pose, const py::object& covariance,
                       const py::object& state) {
             Estimate estimate;
             estimate.pose = pose_from(pose, "pose");
             const Doubles P =
                 doubles_from(covariance, "covariance", Shape{3, 3}, "an array of shape (3, 3)");
             std::copy_n(P.data(), 9, estimate.covariance.data());
             if (!state.is_none()) {
               const Doubles more =
                   doubles_from(state, "state", Shape{-1}, "an array of shape (n,)");
               estimate.state.assign(more.data(), more.data() + more.size());
             }
             return estimate;
           }),
           py::arg("pose"), py::arg("covariance"), py::arg("state") = py::none())
      .def_property_readonly(
          "pose", [](const Estimate& self) { return bindings::to_array(self.pose); },
          "array (3,): x, y (work-area px), heading (rad).")
      .def_property_readonly(
          "covariance",
          [](const Estimate& self) { return bindings::to_array(self.covariance.data(), {3, 3}); },
          "array (3, 3): covariance of the pose.")
      .def_property_readonly(
          "state",
          [](const Estimate& self) {
            return bindings::to_array(self.state.data(),
                                      {static_cast<py::ssize_t>(self.state.size())});
          },
          "array (n,): any further state.")
      .def("__repr__", [](const Estimate& self) {
        return "<Estimate: pose " + py::str(bindings::to_array(self.pose)).cast<std::string>() +
               ">";
      });

  py::class_<Sample>(public_in(module, "robsim.identification"), "Sample", R"(
One sample for the parameter estimator: y = sum(phi * theta, axis=1).
)")
      .def_readonly("k", &Sample::k, "int: the step whose output y is.")
      .def_property_readonly(
          "phi", [](const Sample& self) { return bindings::to_array(self.regression.phi); },
          "array (3, 5): regressors of the axes X, Y and P (heading).")
      .def_property_readonly(
          "y", [](const Sample& self) { return bindings::to_array(self.regression.y.data(), {3}); },
          "array (3,): outputs x, y (work-area px) and heading (rad).")
      .def("__repr__",
           [](const Sample& self) { return "<Sample of step " + std::to_string(self.k) + ">"; });

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
          "array (2,): the input of step k-1 (V).")
      .def_property_readonly(
          "model", [](const WorldState& self) { return self.model; },
          "RobotModel: what define_model returned.")
      .def("__repr__", [](const WorldState& self) {
        return "<WorldState of step " + std::to_string(self.k) + ">";
      });
}

void bind_step(py::module_& module) {
  py::class_<Step, std::shared_ptr<Step>>(public_in(module, "robsim"), "Step", R"(
What the robot half may know of a step, read-only. It fills up from stage to stage.
)")
      .def_readonly("k", &Step::k, "int: number of the step, from 0.")
      .def_readonly("t", &Step::t, "float: time (s).")
      .def_readonly("dt", &Step::dt, "float: sample time (s).")
      .def_property_readonly(
          "last_u", [](const Step& self) { return to_array(readable(self).last_u); },
          "array (2,): the input of the step before, u1 left and u2 right (V).")
      .def_property_readonly("u", &input_of,
                             "array (2,): the input decided in this step, as sent to the motors "
                             "(V). RuntimeError before that.")
      .def_property_readonly(
          "frame", [](const Step& self) { return frame_of(self); }, "Frame: what the camera sees.")
      .def_property_readonly(
          "blobs", [](const Step& self) { return blobs_of(self); },
          "dict of str to list of Blob: per colour the blobs in the frame, the largest first.")
      .def_property_readonly(
          "measurement", [](const Step& self) { return readable(self).measurement; },
          "Measurement or None: where the robot was seen. None before that stage.")
      .def_property_readonly(
          "estimate", [](const Step& self) { return readable(self).estimate; },
          "Estimate or None: what the state estimator returned.")
      .def_property_readonly(
          "parameters",
          [](const Step& self) -> py::object {
            if (!readable(self).parameters) return py::none();
            return bindings::to_array(*self.parameters);
          },
          "array (3, 5) or None: the parameters estimated by now.")
      .def_property_readonly(
          "sample", [](const Step& self) { return readable(self).sample; },
          "Sample or None: the newest complete sample. None at the start, and where a\n"
          "bounce or a missing measurement interrupts the record.")
      .def_property_readonly(
          "estimator", [](const Step& self) { return to_python(self.estimator); },
          "The object that init_parameter_estimator made.")
      .def_readonly("markers", &Step::markers, "MarkerLayout: where the robot carries its markers.")
      .def("__repr__", [](const Step& self) { return "<Step " + std::to_string(self.k) + ">"; });
}

}  // namespace

void bind_simulation(py::module_& module) {
  bind_records(module);
  bind_step(module);

  py::class_<SlottedSimulation>(public_in(module, "robsim._core"), "Simulation",
                                "The loop. Users take robsim.Simulation.",
                                py::custom_type_setup(&collect_garbage))
      .def(py::init(&make_simulation), py::kw_only(), py::arg("area"), py::arg("boundary"),
           py::arg("robot_radius"), py::arg("start"), py::arg("noise"), py::arg("colors"),
           py::arg("markers"), py::arg("smoothing"), py::arg("identify_from"),
           py::arg("controller_seed"), py::arg("noise_seed"), py::arg("dropout"),
           py::arg("dropout_length"), py::arg("dropout_seed"))
      .def("set_stage", &SlottedSimulation::set_stage, py::arg("slot"), py::arg("value"),
           "Put a callable or a native component into a slot; None = the default.")
      .def_property_readonly(
          "minimum_area",
          [](const SlottedSimulation& self) { return self.blob_options().minimum_area; },
          "int: of the blobs in the newest frame (px).")
      .def_property_readonly(
          "maximum_count",
          [](const SlottedSimulation& self) { return self.blob_options().maximum_count; },
          "int: of the blobs of a colour.")
      .def_property_readonly(
          "smoothing", [](const SlottedSimulation& self) { return self.blob_options().smoothing; },
          "int: window of the newest frame (px); 1 = off.")
      .def("start", &SlottedSimulation::start, "Do what comes once, if that has not been done yet.")
      .def(
          "run",
          [](SlottedSimulation& self, std::int64_t steps, py::object progress) {
            if (steps < 0) {
              throw py::value_error("steps must be at least 0, got " + std::to_string(steps));
            }
            PythonInterpreter interpreter(std::move(progress));
            struct Forget {
              StepObject& object;
              ~Forget() { object.forget(); }
            } forget{self.step_object};
            self.run(steps, interpreter);
          },
          py::arg("steps"), py::arg("progress") = py::none(),
          "Run `steps` steps; progress(done) is called every 50 ms or so.")
      .def("reset", &SlottedSimulation::reset, "Go back to the start.")
      .def("columns", &columns_of, "Return the columns of the trace: name -> array (rows, width).")
      .def_property_readonly("has_started", &SlottedSimulation::has_started)
      .def_property_readonly(
          "rows", [](const SlottedSimulation& self) { return self.next_step(); },
          "int: steps recorded by now.")
      .def_property_readonly("is_running", &SlottedSimulation::is_running)
      .def_property_readonly("model", [](const SlottedSimulation& self) { return self.model(); })
      .def_property_readonly(
          "estimator", [](const SlottedSimulation& self) { return to_python(self.estimator()); })
      .def_property_readonly("last_step",
                             [](const SlottedSimulation& self) { return self.last_step(); })
      .def_property_readonly("frame", [](SlottedSimulation& self) { return self.frame(); })
      .def_property_readonly("blobs", [](SlottedSimulation& self) { return self.blobs(); })
      .def(
          "render_step",
          [](SlottedSimulation& self, std::int64_t k) { return self.render_step(k); }, py::arg("k"),
          "Return the frame of a recorded step, drawn anew.");
}
