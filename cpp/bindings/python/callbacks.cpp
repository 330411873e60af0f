#include "python/callbacks.hpp"

#include <atomic>
#include <functional>
#include <stdexcept>
#include <unordered_map>

#include "robsim/simulation/robot/stages.hpp"

namespace robsim::bindings {

namespace {

// Python makes the errors: simulation/callbacks/errors.py.
py::object errors(const char* function) {
  return py::module_::import("robsim.simulation.callbacks.errors").attr(function);
}

template <typename T>
bool is_exactly(const py::object& value) {
  return py::type::of(value).is(py::type::of<T>());
}

bool is_off(const py::object& value) {
  return value.is_none() || (py::isinstance<py::bool_>(value) && !value.cast<bool>());
}

std::atomic<bool> measurement_is_closed = false, estimator_is_closed = false;

[[noreturn]] void refuse_default(const std::string& slot) {
  throw std::invalid_argument("robsim's own " + slot + " is unavailable in this assignment");
}

// The user's own estimator, or robsim's unless it is closed.
std::optional<AxisMatrix> update_open_estimator(const StepPointer& step) {
  if (estimator_is_closed && dynamic_cast<const RecursiveEstimator*>(step->estimator.get())) {
    refuse_default("estimate_parameters");
  }
  return update_estimator(step);
}

bool is_default(const py::object& value) {
  return py::isinstance<py::bool_>(value) && value.cast<bool>();
}

// The result of a callback, as a value of a class of the core.
template <typename T>
T result_from(const py::object& result, const std::string& expected) {
  if (py::isinstance<T>(result)) return result.cast<T>();
  throw py::type_error("the result must be " + expected + ", got " + describe(result));
}

std::optional<AxisMatrix> optional_parameters(const py::object& result) {
  if (result.is_none()) return std::nullopt;
  return axis_matrix_from(result, "the result");
}

std::optional<Measurement> optional_measurement(const py::object& result) {
  if (result.is_none()) return std::nullopt;
  if (PyUnicode_Check(result.ptr()) || !PySequence_Check(result.ptr())) {
    return result_from<Measurement>(result, "a Measurement, or None = not seen");
  }
  return measurement_from(result, "the result");
}

Estimate estimate_from(const py::object& result) {
  return result_from<Estimate>(result, "an Estimate(pose, covariance)");
}

Input voltages_from(const py::object& result) { return input_from(result, "the result"); }

std::shared_ptr<ParameterEstimator> estimator_from(const py::object& result) {
  if (result.is_none()) throw py::type_error("the result must be an estimator object, got None");
  if (is_exactly<GuardedLeastSquares>(result)) {
    return std::make_shared<RecursiveEstimator>(
        result.cast<std::shared_ptr<GuardedLeastSquares>>());
  }
  return std::make_shared<ObjectEstimator>(result);
}

void set_define_model(Stages& stages, const py::object& value) {
  if (value.is_none()) {
    stages.define_model = default_model;
    return;
  }
  if (is_exactly<RobotModel>(value)) {
    stages.define_model = [model = value.cast<RobotModel>()] { return model; };
    return;
  }
  stages.define_model = [callback = Callback("define_model", value)] {
    const py::object result = callback(-1);
    return callback.convert(-1, [&] { return result_from<RobotModel>(result, "a RobotModel"); });
  };
}

void set_init_parameter_estimator(Stages& stages, const py::object& value) {
  if (value.is_none()) {
    stages.init_parameter_estimator = default_parameter_estimator;
    return;
  }
  if (py::isinstance<PythonRemoteRobot>(value)) {
    stages.init_parameter_estimator = [robot =
                                           &value.cast<PythonRemoteRobot&>()](const RobotModel&) {
      return std::make_shared<RemoteEstimator>(*robot);
    };
    return;
  }
  stages.init_parameter_estimator =
      [callback = Callback("init_parameter_estimator", value)](const RobotModel& model) {
        const py::object result = callback(-1, py::cast(model));
        return callback.convert(-1, [&] { return estimator_from(result); });
      };
}

// Fills a slot that is called at each step: off, a native stage if there is one for the value, one
// in another process, or a callable whose result `convert` takes. SlotValues keep the value alive.
template <typename Result>
void set_step_slot(Slot<Result(const StepPointer&)>& slot, const char* name,
                   const py::object& value, StepObject& object,
                   std::function<Result(const StepPointer&)> native,
                   Result (RemoteRobot::*of_robot)(const StepPointer&),
                   Result (RemoteWorld::*of_world)(const StepPointer&),
                   Result (*convert)(const py::object&)) {
  if (is_off(value)) {
    slot = {};
  } else if (native) {
    slot = {std::move(native), false};
  } else if (py::isinstance<PythonRemoteRobot>(value)) {
    slot = {std::bind(of_robot, &value.cast<PythonRemoteRobot&>(), std::placeholders::_1), true};
  } else if (of_world && py::isinstance<PythonRemoteWorld>(value)) {
    slot = {std::bind(of_world, &value.cast<PythonRemoteWorld&>(), std::placeholders::_1), true};
  } else {
    slot = {[&object, convert, callback = Callback(name, value)](const StepPointer& step) {
              const py::object result = callback(step->k, object.of(step));
              return callback.convert(step->k, [&] { return convert(result); });
            },
            true};
  }
}

// A class of the user's own that builds on a ready controller is called like any callable.
std::function<Input(const StepPointer&)> native_controller(const py::object& value) {
  if (!is_exactly<Spin>(value) && !is_exactly<DriveAround>(value) && !is_exactly<Replay>(value)) {
    return {};
  }
  const auto controller = value.cast<std::shared_ptr<Controller>>();
  return [controller](const StepPointer& step) { return (*controller)(*step); };
}

template <typename Result>
std::function<Result(const StepPointer&)> if_default(
    const py::object& value, std::function<Result(const StepPointer&)> stage) {
  return is_default(value) ? std::move(stage) : nullptr;
}

}  // namespace

Callback::Callback(std::string slot, py::handle function, std::string what)
    : slot_(std::move(slot)),
      what_(what.empty() ? "the callback " + slot_ : std::move(what)),
      function_(function) {
  if (!PyCallable_Check(function_.ptr())) {
    throw py::type_error(slot_ + " must be callable, got " + describe(function_));
  }
}

void Callback::fail(std::int64_t k) const {
  py::error_already_set error;
  if (error.trace()) PyException_SetTraceback(error.value().ptr(), error.trace().ptr());
  try {
    errors("failed")(error.value(), slot_, what_, k, function_);
  } catch (const py::error_already_set&) {
    // An exception that takes no note: it is what counts.
  }
  throw error;
}

void Callback::refuse(std::int64_t k) const {
  const py::error_already_set error;
  const py::object refused = errors("refused")(error.value(), slot_, what_, k, function_);
  PyErr_SetObject(py::type::of(refused).ptr(), refused.ptr());
  throw py::error_already_set();
}

void ObjectEstimator::check() const { errors("check_estimator")(object_); }

AxisMatrix ObjectEstimator::update(Step& step) {
  if (!py::hasattr(object_, "update")) check();
  const py::object method = object_.attr("update");
  const Callback update("estimate_parameters", method,
                        "the callback estimate_parameters (its default: step.estimator.update)");
  const Regression& sample = step.find_sample().value().regression;
  const py::object result = update(step.k, to_array(sample.phi), to_array(sample.y.data(), {3}));
  return update.convert(step.k, [&] { return axis_matrix_from(result, "the result"); });
}

py::object to_python(const std::shared_ptr<ParameterEstimator>& estimator) {
  if (const auto* object = dynamic_cast<const ObjectEstimator*>(estimator.get())) {
    return object->object();
  }
  if (const auto* native = dynamic_cast<const RecursiveEstimator*>(estimator.get())) {
    return py::cast(native->filters());
  }
  return py::none();
}

void close_default(const std::string& slot) {
  (slot == "measure" ? measurement_is_closed : estimator_is_closed) = true;
}

SlottedLoop::SlottedLoop(std::shared_ptr<World> world, const RobotOptions& robot_options,
                         IdentifyFrom identify_from)
    : Loop(std::move(world), robot_options, identify_from) {
  robot().set_is_kept([this](const StepPointer& step) {
    return !step_object.is_only_holder(step) && step.use_count() > 1;
  });
}

void SlottedLoop::set_slot(const std::string& slot, const py::object& value) {
  Stages& s = stages();
  const char* const name = slot.c_str();
  if (slot == "define_model") {
    set_define_model(s, value);
  } else if (slot == "init_parameter_estimator") {
    set_init_parameter_estimator(s, value);
  } else if (slot == "estimate_parameters") {
    set_step_slot(s.estimate_parameters, name, value, step_object,
                  if_default<std::optional<AxisMatrix>>(value, update_open_estimator),
                  &RemoteRobot::estimate_parameters, &RemoteWorld::estimate_parameters,
                  optional_parameters);
  } else if (slot == "measure") {
    if (measurement_is_closed && is_default(value)) refuse_default(slot);
    set_step_slot(s.measure, name, value, step_object,
                  if_default<std::optional<Measurement>>(value, &Step::detect),
                  &RemoteRobot::measure, &RemoteWorld::measure, optional_measurement);
  } else if (slot == "estimate_state") {
    set_step_slot(s.estimate_state, name, value, step_object, {}, &RemoteRobot::estimate_state,
                  &RemoteWorld::estimate_state, estimate_from);
  } else {
    set_step_slot<Input>(s.control, name, value, step_object, native_controller(value),
                         &RemoteRobot::control, nullptr, voltages_from);
  }
  values[slot] = value;
}

py::handle SlottedLoop::also_held() const {
  const auto* estimator = dynamic_cast<const ObjectEstimator*>(robot().estimator().get());
  if (guard().is_running()) return {};  // another thread may be changing the step
  if (!estimator || !robot().has_estimator_alone()) return {};
  return estimator->object();
}

void SlottedLoop::let_go() {
  if (!guard().is_running()) robot().reset();
}

void SlottedLoop::refuse(const ResultError& error) const {
  PyErr_SetString(PyExc_ValueError, error.what());
  Callback(error.slot(), values.at(error.slot())).refuse(error.k());
}

}  // namespace robsim::bindings
