#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

#include "python/callbacks.hpp"
#include "python/interpreter.hpp"
#include "python/signature.hpp"
#include "robsim/simulation/loop.hpp"
#include "robsim/simulation/seam/thread_guard.hpp"
#include "robsim/simulation/trace.hpp"

using namespace robsim;
using namespace robsim::bindings;

template <>
constexpr Choices<IdentifyFrom> robsim::bindings::choices<IdentifyFrom> = {
    {"truth", IdentifyFrom::truth},
    {"measurement", IdentifyFrom::measurement},
    {"estimate", IdentifyFrom::estimate}};
template <>
constexpr Choices<Given> robsim::bindings::choices<Given> = {
    {"all", Given::all}, {"frames", Given::frames}, {"blobs", Given::blobs}, {"pose", Given::pose}};
template <>
constexpr Choices<Stage> robsim::bindings::choices<Stage> = {
    {"world", Stage::world},     {"estimate_parameters", Stage::estimate_parameters},
    {"measure", Stage::measure}, {"estimate_state", Stage::estimate_state},
    {"control", Stage::control}, {"send", Stage::send}};

namespace {

using Units = py::typing::Dict<py::str, py::str>;

Units units_of(const TraceGroup& group) {
  Units units;
  for (const TraceField& field : group.fields) units[field.name.c_str()] = field.unit;
  return units;
}

py::typing::Tuple<int, py::ellipsis> shape_of(const TraceGroup& group) {
  return py::tuple(py::cast(group.shape));
}

}  // namespace

void bind_trace(py::module_& module) {
  bindings::Class<TraceGroup>(public_in(module, "robsim.trace"), "TraceGroup", R"(
Columns of a trace that are recorded together.
)")
      .def_readonly("name", &TraceGroup::name, "str: name of the group.")
      .def_property_readonly("shape", &shape_of, "tuple of int: shape of the numbers of a step.")
      .def_property_readonly("units", &units_of,
                             "dict of str to str: unit of each column, in the order of a row.")
      .def_readonly("description", &TraceGroup::description, "str: description in one line.")
      .def_readonly("is_flag", &TraceGroup::is_flag, "bool: a number above 0 means true.")
      .def_readonly("missing", &TraceGroup::missing, "float: value of steps without a record.")
      .def_readonly("in_simulated", &TraceGroup::in_simulated,
                    "bool: required in the trace of a simulated run.")
      .def_readonly("in_recorded", &TraceGroup::in_recorded,
                    "bool: required in the trace of external frames.");

  public_in(module, "robsim._core").def("trace_schema", &trace_schema, R"(
Return the groups of columns of a trace, without `state` and `blobs_<color>`, whose widths vary.

Returns
-------
list of TraceGroup
    The groups in the order of the documentation.
)");
}

namespace {

void* release_interpreter() { return PyGILState_Check() ? PyEval_SaveThread() : nullptr; }

void acquire_interpreter(void* state) { PyEval_RestoreThread(static_cast<PyThreadState*>(state)); }

// Python is about to end: the runs of other threads stop their robots, and never come back.
std::atomic<bool> is_end_near{false};
std::thread::id ending;  // the thread that ends Python, which may still run loops itself
std::atomic<int> runs_under_way{0};
thread_local int runs_here = 0;  // more than one: a callback runs a second loop
struct EndIsNear {};

// The wait is short: a callback may take hours.
void end_all_runs() {
  ending = std::this_thread::get_id();
  is_end_near = true;
  const WithoutInterpreter others;
  for (int ms = 0; ms < 1000 && runs_under_way > 0; ++ms) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

// Called between two steps: signals, and a progress callback.
Loop::Pulse pulse(const py::object& progress) {
  return [progress](std::int64_t done) {
    if (is_end_near && std::this_thread::get_id() != ending) throw EndIsNear();
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (!progress.is_none()) progress(done);
  };
}

std::unique_ptr<SlottedLoop> make_loop(const std::shared_ptr<World>& world,
                                       const std::vector<ColorClass>& colors,
                                       const MarkerLayout& markers, std::optional<int> smoothing,
                                       IdentifyFrom identify_from, std::uint64_t controller_seed) {
  return std::make_unique<SlottedLoop>(
      world, RobotOptions{colors, markers, smoothing, controller_seed}, identify_from);
}

// Does not keep the callable alive, as Callback. Its exceptions are printed, and end no run.
Loop::Observer observer_of(const py::object& observer) {
  if (observer.is_none()) return {};
  if (py::isinstance<PythonRemoteWorld>(observer)) {
    return [world = &observer.cast<PythonRemoteWorld&>()](const Loop::Outcome& outcome) {
      world->end_step(*outcome.step);
    };
  }
  return [call = py::handle(observer)](const Loop::Outcome& outcome) {
    try {
      const Step& step = *outcome.step;
      call(outcome.step, step.u, step.measurement, step.detection, outcome.t_arrival,
           outcome.t_sent, outcome.interrupted);
    } catch (py::error_already_set& error) {
      if (error.matches(PyExc_KeyboardInterrupt)) {
        PyErr_SetInterrupt();  // put off: the run sees to it
      } else {
        error.discard_as_unraisable("the observer of the steps");
      }
    }
  };
}

// Forgets the step's object at the end of its life.
struct RunScope {
  explicit RunScope(SlottedLoop& loop)
      : object(loop.guard().is_running() ? nullptr : &loop.step_object) {
    ++runs_under_way;
    ++runs_here;
  }
  ~RunScope() {
    if (object) object->forget();
    --runs_under_way;
    --runs_here;
  }
  StepObject* object;  // null: another run is under way, whose it is
};

// Does something that the loop does between two looks of the user's.
template <typename Work>
auto in_run(SlottedLoop& loop, const Work& work) {
  try {
    const RunScope scope(loop);
    return work();
  } catch (const ResultError& error) {
    loop.refuse(error);
  } catch (const EndIsNear&) {
    if (runs_here > 0) throw std::runtime_error("Python ends");  // through the callback
    const WithoutInterpreter others;
    wait_for_the_end();
  }
}

// Views of the rows recorded so far; they stay unchanged while the run continues.
using Columns = py::typing::Dict<py::str, py::array_t<double>>;

Columns columns_of(const SlottedLoop& self) {
  Columns columns;
  const Trace::Snapshot trace = self.trace().snapshot();
  const py::ssize_t rows = trace.rows;
  for (const Trace::Column& column : trace.columns) {
    const auto width = static_cast<py::ssize_t>(column.width());
    auto* memory = new Trace::Memory(column.memory());
    columns[column.name().c_str()] =
        read_only(py::array_t<double>({rows, width}, (*memory)->data(), owner_of(memory)));
  }
  return columns;
}

BlobOptions blob_options_of(const SlottedLoop& self) {
  const RunGuard::Look look(self.guard());
  return self.robot().vision().options();
}

std::vector<MissedDetections> missed_of(const SlottedLoop& self) {
  const RunGuard::Look look(self.guard());
  std::vector<MissedDetections> result;
  for (const auto& [reason, missed] : self.robot().missed()) result.push_back(missed);
  std::stable_sort(result.begin(), result.end(),
                   [](const auto& a, const auto& b) { return a.steps > b.steps; });
  return result;
}

}  // namespace

void bind_loop(py::module_& module) {
  set_interpreter_lock({&release_interpreter, &acquire_interpreter});
  py::module_::import("atexit").attr("register")(py::cpp_function(&end_all_runs));

  Class<Sights, std::shared_ptr<Sights>>(public_in(module, "robsim._core"), "Sights",
                                         "Frames and detections of a run, for other runs.")
      .def(py::init<>());
  module.def("close_default", &close_default, "slot"_a,
             "Refuse robsim's own measurement or parameter estimator from now on.");
  Class<SlottedLoop>(public_in(module, "robsim._core"), "Loop",
                     "The loop. Users take robsim.Simulation or robsim.Experiment.",
                     py::custom_type_setup(&collect_garbage<SlottedLoop>))
      .def(py::init(&make_loop), py::kw_only(), "world"_a, "colors"_a, "markers"_a, "smoothing"_a,
           "identify_from"_a, "controller_seed"_a)
      .def("set_slot", &SlottedLoop::set_slot, "slot"_a, "value"_a,
           "Put a callable or a native component into a slot; None = the default.")
      .def(
          "set_controller_seed",
          [](SlottedLoop& self, std::uint64_t seed) {
            const RunGuard::Look look(self.guard());
            self.robot().set_controller_seed(seed);
          },
          "seed"_a)
      .def(
          "set_given",
          [](SlottedLoop& self, Given given, bool samples) {
            const RunGuard::Look look(self.guard());
            self.robot().set_given(given, samples);
          },
          "given"_a, "samples"_a, "Limit the callbacks to this data, from the next step on.")
      .def(
          "set_vision",
          [](SlottedLoop& self, const std::vector<ColorClass>& colors, const MarkerLayout& markers,
             std::optional<int> smoothing) {
            const RunGuard::Look look(self.guard());
            self.robot().set_vision(colors, markers, smoothing);
          },
          "colors"_a, "markers"_a, "smoothing"_a,
          "Look for other markers, in other colours, from the next step on.")
      .def_property_readonly(
          "minimum_area", [](SlottedLoop& self) { return blob_options_of(self).minimum_area; },
          "int: minimum area of blobs in the newest frame (px).")
      .def_property_readonly(
          "maximum_count", [](SlottedLoop& self) { return blob_options_of(self).maximum_count; },
          "int: maximum number of blobs of a colour.")
      .def_property_readonly(
          "smoothing", [](SlottedLoop& self) { return blob_options_of(self).smoothing; },
          "int: window of the newest frame (px); 1 = off.")
      .def(
          "set_observer",
          [](SlottedLoop& self, const py::object& observer) {
            self.set_observer(observer_of(observer));
            self.values["observer"] = observer;
          },
          "observer"_a,
          "Call observer(step, u, measurement, detection, t_arrival, t_sent, interrupted) after "
          "each step, with None for missing values; observer None = no observer.")
      .def("share", &SlottedLoop::share, "sights"_a,
           "Let the next runs use the sights of other runs with the same world and seed.")
      .def("start", &SlottedLoop::start, "Do the actions at the start, unless they are done.")
      .def(
          "run",
          [](SlottedLoop& self, std::int64_t steps, const py::object& progress, bool stops_robot) {
            return in_run(self, [&] { return self.run(steps, pulse(progress), stops_robot); });
          },
          "steps"_a, "progress"_a = py::none(), "stops_robot"_a = true,
          "Run `steps` steps; progress(done) is called every 50 ms or so. True = the world has "
          "ended.")
      .def(
          "step_stage",
          [](SlottedLoop& self, const py::object& progress) {
            return in_run(self, [&] { return self.step_stage(pulse(progress)); });
          },
          "progress"_a = py::none(),
          "Do the next enabled stage and return its name; None = the world has ended.")
      .def("stop", &SlottedLoop::stop, "End the current run; False without a run.")
      .def("stop_robot", &SlottedLoop::stop_robot_between_runs, "Send the stop input, if set.")
      .def("reset", &SlottedLoop::reset, "Return to the start.")
      .def("columns", &columns_of, "Return the columns of the trace: name -> array (rows, width).")
      .def(
          "check_thread", [](const SlottedLoop& self) { self.guard().check_thread(); },
          "Raise RuntimeError while another thread runs the loop.")
      .def_property_readonly("has_started", &SlottedLoop::has_started)
      .def_property_readonly(
          "rows", [](const SlottedLoop& self) { return self.trace().rows(); },
          "int: number of recorded steps.")
      .def_property_readonly("is_running",
                             [](const SlottedLoop& self) { return self.guard().is_running(); })
      .def_property_readonly(
          "stage", [](const SlottedLoop& self) { return self.stage(); },
          "str: the current or next stage.")
      .def_property_readonly("model", [](const SlottedLoop& self) { return self.robot().model(); })
      .def_property_readonly(
          "estimator", [](const SlottedLoop& self) { return to_python(self.robot().estimator()); })
      .def_property_readonly("missed_detections", &missed_of,
                             "list of MissedDetections: the most frequent reason first.")
      .def_property_readonly(
          // Without a claim, which would refuse a stop of the robot by another thread meanwhile.
          "doubts", [](const SlottedLoop& self) { return self.robot().doubts(); },
          "list of str: implausible results of stages, each kind once per run.")
      .def_property_readonly("last_step", [](const SlottedLoop& self) { return self.last_step(); })
      .def_property_readonly(
          "last_frame",
          [](const SlottedLoop& self) -> std::optional<Frame> {
            const Frame* frame = self.last_step()->look();
            return frame ? std::optional(*frame) : std::nullopt;
          },
          "Frame or None: the newest step's frame, even if callbacks do not get it.");
}
