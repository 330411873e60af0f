#include <cmath>

#include "python/values.hpp"
#include "robsim/simulation/robot/step.hpp"
#include "robsim/simulation/world/external_world.hpp"

using namespace robsim;
using namespace robsim::bindings;

namespace {

Arrived make_observation(const std::optional<Frame>& frame, const std::optional<double>& t,
                         const std::optional<Input>& last_u,
                         const std::optional<MeasurementLike>& measurement,
                         const std::optional<Sample>& sample, bool interrupted) {
  if (t && !std::isfinite(*t)) throw py::value_error("t must be finite (s)");
  Arrived arrived;
  arrived.frame = frame;
  arrived.t = t;
  arrived.known.last_u = last_u;
  arrived.known.measurement = measurement;
  arrived.known.sample = sample;
  arrived.known.interrupted = interrupted;
  return arrived;
}

Estimate make_estimate(const Pose& pose, const PoseCovariance& covariance,
                       const std::optional<ArrayLike>& state) {
  Estimate estimate;
  estimate.pose = pose;
  estimate.covariance = covariance;
  if (state) {
    const Doubles more = doubles_from(*state, "state", Shape{-1}, "an array of shape (n,)");
    estimate.state.assign(more.data(), more.data() + more.size());
  }
  return estimate;
}

py::str repr(const Estimate& self) {
  const Eigen::Vector3d sd = self.covariance.diagonal().cwiseSqrt();
  return py::str("<Estimate: pose {}, standard deviations {:.3g}, {:.3g} px, {:.3g} rad>")
      .format(to_array(self.pose).attr("tolist")(), sd[0], sd[1], sd[2]);
}

void bind_estimate_and_sample(py::module_& module) {
  Class<Estimate> estimate(public_in(module, "robsim"), "Estimate", R"(
The result of a state estimator in a step.

Parameters
----------
pose : array (3,)
    x, y (work-area px), heading (rad).
covariance : array (3, 3)
    Its covariance.
state : array (n,), optional
    Any further state, n the same at every step.

Examples
--------
>>> estimate = robsim.Estimate((600, 500, 0.1), np.diag([4, 4, 0.01]))
>>> np.sqrt(np.diag(estimate.covariance))  # px, px, rad
array([2. , 2. , 0.1])
)");
  const auto state = [](const Estimate& self) {
    return Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(
        self.state.data(), static_cast<Eigen::Index>(self.state.size())));
  };
  const Fields fields(
      &make_estimate,
      Field("pose", &Estimate::pose, "array (3,): x, y (work-area px), heading (rad)."),
      Field("covariance", &Estimate::covariance, "array (3, 3): covariance of the pose."),
      Field("state", state, "array (n,): any further state.", std::nullopt));
  define_value(estimate, fields);
  estimate.def("__repr__", &repr);

  Class<Sample> sample(public_in(module, "robsim.estimation"), "Sample", R"(
One sample for the parameter estimator: y = sum(phi * theta, axis=1).

Parameters
----------
phi : array (3, 5)
    Regressors of the axes X, Y and P (heading).
y : array (3,)
    Outputs x, y (work-area px) and heading (rad).
k : int
    The step of the output y.

Examples
--------
>>> phi = np.tile([10.0, 9.0, 0.5, 0.5, 1.0], (3, 1))
>>> sample = robsim.estimation.Sample(phi, y=(10.8, 10.8, 10.8), k=2)
>>> sample.phi.shape, sample.k
((3, 5), 2)
)");
  const auto make = [](const AxisMatrix& phi, const ArrayLike& y, std::int64_t k) {
    check_step_number(k);
    const Doubles outputs = doubles_from(y, "y", Shape{3}, "three outputs (x, y, heading)");
    return Sample{{phi, {outputs.at(0), outputs.at(1), outputs.at(2)}}, k};
  };
  const auto y = [](const Sample& self) { return Eigen::VectorXd(self.regression.y); };
  const Fields sample_fields(
      make,
      Field(
          "phi", [](const Sample& self) { return self.regression.phi; },
          "array (3, 5): regressors of the axes X, Y and P (heading)."),
      Field("y", y, "array (3,): outputs x, y (work-area px) and heading (rad)."),
      Field("k", &Sample::k, "int: the step of the output y."));
  define_value(sample, sample_fields);
  define_repr(sample, "<Sample of step {0.k}>");
}

void bind_observation(py::module_& module) {
  Class<Arrived> observation(public_in(module, "robsim"), "Observation", R"(
An item of the `frames` of an `Experiment`, with more data than a plain frame.

Parameters
----------
frame : Frame, optional
    The camera's frame. None = no frame in this step.
t : float, optional
    Time of the step (s). Default: the frame's time, or one sample time after the previous step.
last_u : array (2,), optional
    The input that the robot really got since the last step (V), if different from the controller's.
measurement : Measurement or array (3,), optional
    The robot's pose, if measured externally: ``measure=True`` keeps it unchanged.
sample : Sample, optional
    The sample for the parameter estimator, if made externally.
interrupted : bool
    The robot was stopped since the last step: no sample spans the stop.

Examples
--------
>>> dark = robsim.Frame(np.zeros((480, 640, 3), np.uint8))
>>> seen = robsim.Observation(dark, t=0.2, measurement=(600, 500, 0.1))
>>> seen.measurement.pose.tolist()
[600.0, 500.0, 0.1]
)");
  const auto known = [](auto Observation::* member) {
    return [member](const Arrived& self) { return self.known.*member; };
  };
  const Fields fields(
      &make_observation,
      Field("frame", &Arrived::frame, "Frame or None: the camera's frame.", std::nullopt), by_name,
      Field("t", &Arrived::t, "float or None: time of the step (s).", std::nullopt),
      Field("last_u", known(&Observation::last_u),
            "array (2,) or None: the input since the last step (V).", std::nullopt),
      Field("measurement", known(&Observation::measurement),
            "Measurement or None: the measured pose.", std::nullopt),
      Field("sample", known(&Observation::sample),
            "Sample or None: the sample for the parameter estimator.", std::nullopt),
      Field("interrupted", known(&Observation::interrupted),
            "bool: the robot was stopped since the last step.", false));
  define_value(observation, fields);
  observation.def("__repr__", [](const Arrived& self) {
    return std::string("<Observation ") + (self.frame ? "with" : "without") + " a frame>";
  });
}

}  // namespace

void bind_records(py::module_& module) {
  bind_estimate_and_sample(module);
  bind_observation(module);
}
