#include "python/callbacks.hpp"

#include <functional>
#include <unordered_map>

namespace robsim::bindings {

namespace {

// File and line of a Python function, or the type of another callable.
std::string location(py::object function) {
  while (py::hasattr(function, "__wrapped__")) function = function.attr("__wrapped__");
  if (!py::hasattr(function, "__code__")) {
    return "  in an object of " + py::repr(py::type::of(function)).cast<std::string>();
  }
  const py::object code = function.attr("__code__");
  return "  File \"" + py::str(code.attr("co_filename")).cast<std::string>() + "\", line " +
         py::str(code.attr("co_firstlineno")).cast<std::string>() + ", in " +
         py::str(code.attr("co_name")).cast<std::string>();
}

template <typename T>
bool is_exactly(const py::object& value) {
  return py::type::of(value).is(py::type::of<T>());
}

bool is_off(const py::object& value) {
  return value.is_none() || (py::isinstance<py::bool_>(value) && !value.cast<bool>());
}

bool is_default(const py::object& value) {
  return py::isinstance<py::bool_>(value) && value.cast<bool>();
}

std::optional<AxisMatrix> optional_parameters(const py::object& result) {
  if (result.is_none()) return std::nullopt;
  return axis_matrix_from(result, "the result");
}

std::optional<Measurement> optional_measurement(const py::object& result) {
  if (result.is_none()) return std::nullopt;
  if (py::isinstance<Measurement>(result)) return result.cast<Measurement>();
  if (PyUnicode_Check(result.ptr()) || !PySequence_Check(result.ptr())) {
    throw py::type_error("the result must be a Measurement, or None = not seen, got " +
                         describe(result));
  }
  return Measurement{pose_from(result, "the result")};
}

Estimate estimate_from(const py::object& result) {
  if (!py::isinstance<Estimate>(result)) {
    throw py::type_error("the result must be an Estimate(pose, covariance), got " +
                         describe(result));
  }
  return result.cast<Estimate>();
}

RobotModel model_from(const py::object& result) {
  if (!py::isinstance<RobotModel>(result)) {
    throw py::type_error("the result must be a RobotModel, got " + describe(result));
  }
  return result.cast<RobotModel>();
}

std::shared_ptr<ParameterEstimator> estimator_from(const py::object& result) {
  if (result.is_none()) throw py::type_error("the result must be an estimator object, got None");
  if (is_exactly<RecursiveLeastSquares>(result)) {
    return std::make_shared<RecursiveEstimator>(
        result.cast<std::shared_ptr<RecursiveLeastSquares>>());
  }
  return std::make_shared<ObjectEstimator>(result);
}

void set_define_model(Stages& stages, const py::object& value) {
  if (value.is_none()) {
    stages.define_model = [] { return RobotModel(); };
    return;
  }
  if (is_exactly<RobotModel>(value)) {
    stages.define_model = [model = value.cast<RobotModel>()] { return model; };
    return;
  }
  stages.define_model = [callback = Callback("define_model", value)] {
    const py::object result = callback(-1);
    return callback.convert(-1, [&] { return model_from(result); });
  };
}

void set_init_parameter_estimator(Stages& stages, const py::object& value) {
  if (value.is_none()) {
    stages.init_parameter_estimator = [](const RobotModel&) {
      return std::make_shared<RecursiveEstimator>(std::make_shared<RecursiveLeastSquares>(5, 3));
    };
    return;
  }
  stages.init_parameter_estimator =
      [callback = Callback("init_parameter_estimator", value)](const RobotModel& model) {
        const py::object result = callback(-1, py::cast(model));
        return callback.convert(-1, [&] { return estimator_from(result); });
      };
}

void set_estimate_parameters(Stages& stages, const py::object& value, StepObject& object) {
  if (is_off(value)) {
    stages.estimate_parameters = {};
    return;
  }
  if (is_default(value)) {
    stages.estimate_parameters = {[](const StepPointer& step) -> std::optional<AxisMatrix> {
                                    if (!step->sample) return std::nullopt;
                                    return step->estimator->update(*step);
                                  },
                                  false};
    return;
  }
  stages.estimate_parameters = {
      [&object, callback = Callback("estimate_parameters", value)](const StepPointer& step) {
        const py::object result = callback(step->k, object.of(step));
        return callback.convert(step->k, [&] { return optional_parameters(result); });
      },
      true};
}

void set_measure(Stages& stages, const py::object& value, StepObject& object) {
  if (is_off(value)) {
    stages.measure = {};
    return;
  }
  if (is_default(value)) {
    stages.measure = {[](const StepPointer& step) {
                        return locate(*step->blobs, step->markers(), step->frame->plane_map);
                      },
                      false};
    return;
  }
  stages.measure = {[&object, callback = Callback("measure", value)](const StepPointer& step) {
                      const py::object result = callback(step->k, object.of(step));
                      return callback.convert(step->k,
                                              [&] { return optional_measurement(result); });
                    },
                    true};
}

void set_estimate_state(Stages& stages, const py::object& value, StepObject& object) {
  if (is_off(value)) {
    stages.estimate_state = {};
    return;
  }
  stages.estimate_state = {
      [&object, callback = Callback("estimate_state", value)](const StepPointer& step) {
        const py::object result = callback(step->k, object.of(step));
        return callback.convert(step->k, [&] { return estimate_from(result); });
      },
      true};
}

void set_control(Stages& stages, const py::object& value, StepObject& object) {
  if (value.is_none()) {
    stages.control = {};
    return;
  }
  // A class of the user's own that builds on a ready controller is called like any callable.
  if (is_exactly<Spin>(value) || is_exactly<DriveAround>(value) || is_exactly<Replay>(value)) {
    const auto controller = value.cast<std::shared_ptr<Controller>>();
    stages.control = {[controller](const StepPointer& step) { return (*controller)(*step); },
                      false};
    return;
  }
  stages.control = {[&object, callback = Callback("control", value)](const StepPointer& step) {
                      const py::object result = callback(step->k, object.of(step));
                      return callback.convert(step->k,
                                              [&] { return input_from(result, "the result"); });
                    },
                    true};
}

}  // namespace

Callback::Callback(std::string slot, py::handle function, std::string what)
    : what_(what.empty() ? "the callback " + slot : std::move(what)), function_(function) {
  if (!PyCallable_Check(function_.ptr())) {
    throw py::type_error(slot + " must be callable, got " + describe(function_));
  }
}

std::string Callback::where(std::int64_t k) const {
  return "in " + what_ + (k < 0 ? " at the start" : " at step " + std::to_string(k));
}

void Callback::add_note(const py::error_already_set& error, std::int64_t k) const {
  try {
    error.value().attr("add_note")(where(k));
  } catch (const py::error_already_set&) {
    // An exception class that takes no notes: the exception itself is what counts.
  }
}

std::string Callback::blame(std::int64_t k, const std::string& what) const {
  return where(k) + ": " + what + "\n" + location(py::reinterpret_borrow<py::object>(function_));
}

AxisMatrix ObjectEstimator::update(const Step& step) {
  const std::string name = "estimate_parameters (its default: step.estimator.update)";
  if (!py::hasattr(object_, "update")) {
    throw py::type_error("in the callback " + name + " at step " + std::to_string(step.k) +
                         ": the object that init_parameter_estimator returned must have a method "
                         "update(phi, y), got " +
                         describe(object_));
  }
  const py::object method = object_.attr("update");
  const Callback update(name, method);
  const Regression& sample = step.sample.value().regression;
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

SlottedLoop::SlottedLoop(std::shared_ptr<World> world, const RobotOptions& robot_options,
                         IdentifyFrom identify_from)
    : Loop(std::move(world), robot_options, identify_from) {
  robot().set_is_kept([this](const StepPointer& step) {
    return !step_object.is_only_holder(step) && step.use_count() > 1;
  });
}

void SlottedLoop::set_slot(const std::string& slot, const py::object& value) {
  const std::unordered_map<std::string, std::function<void(Stages&)>> setters = {
      {"define_model", [&](Stages& s) { set_define_model(s, value); }},
      {"init_parameter_estimator", [&](Stages& s) { set_init_parameter_estimator(s, value); }},
      {"estimate_parameters", [&](Stages& s) { set_estimate_parameters(s, value, step_object); }},
      {"measure", [&](Stages& s) { set_measure(s, value, step_object); }},
      {"estimate_state", [&](Stages& s) { set_estimate_state(s, value, step_object); }},
      {"control", [&](Stages& s) { set_control(s, value, step_object); }},
  };
  setters.at(slot)(stages());
  values[slot] = value;
}

}  // namespace robsim::bindings
