#include <pybind11/stl.h>

#include <cmath>

#include "python/numpy.hpp"
#include "python/signature.hpp"
#include "python/values.hpp"
#include "robsim/simulation/robot/step.hpp"
#include "robsim/simulation/world/external_world.hpp"
#include "simulation/fields.hpp"

namespace py = pybind11;
using namespace robsim;
using namespace robsim::bindings;

namespace {

Arrived make_observation(const std::optional<Frame>& frame, const std::optional<double>& t,
                         const std::optional<ArrayLike>& last_u,
                         const std::optional<MeasurementLike>& measurement,
                         const std::optional<Sample>& sample, bool interrupted) {
  Arrived arrived;
  arrived.frame = frame;
  if (t && !std::isfinite(*t)) throw py::value_error("t must be finite (s)");
  arrived.t = t;
  if (last_u) arrived.known.last_u = input_from(*last_u, "last_u");
  if (measurement) arrived.known.measurement = measurement_from(*measurement, "measurement");
  arrived.known.sample = sample;
  arrived.known.interrupted = interrupted;
  return arrived;
}

Estimate make_estimate(const ArrayLike& pose, const ArrayLike& covariance,
                       const std::optional<ArrayLike>& state) {
  Estimate estimate;
  estimate.pose = pose_from(pose, "pose");
  estimate.covariance = covariance_from(covariance, "covariance");
  if (state) {
    const Doubles more = doubles_from(*state, "state", Shape{-1}, "an array of shape (n,)");
    estimate.state.assign(more.data(), more.data() + more.size());
  }
  return estimate;
}

std::string repr(const Estimate& self) {
  const py::object pose = bindings::to_array(self.pose).attr("tolist")();
  const Eigen::Vector3d sd = self.covariance.diagonal().cwiseSqrt();
  const py::tuple shown = py::make_tuple(sd[0], sd[1], sd[2]);
  return "<Estimate: pose " + py::repr(pose).cast<std::string>() + ", standard deviations " +
         py::str("{:.3g}, {:.3g} px, {:.3g} rad").format(*shown).cast<std::string>() + ">";
}

void define_estimate_value(Class<Estimate>& cls) {
  using Covariance = std::array<double, 9>;
  const auto covariance = [](const Estimate& self) {
    Covariance values;
    std::copy_n(self.covariance.data(), 9, values.begin());
    return values;
  };
  const auto make = [](const Triple& pose, const Covariance& P, const std::vector<double>& state) {
    Estimate estimate{pose_of(pose), {}, state};
    std::copy_n(P.begin(), 9, estimate.covariance.data());
    return estimate;
  };
  const Fields fields(make, Field("pose", [](const Estimate& e) { return triple_of(e.pose); }),
                      Field("covariance", covariance), Field("state", &Estimate::state));
  define_equality(cls, fields);
  define_hash(cls, fields);
  define_pickle(cls, fields);
}

void define_sample_value(Class<Sample>& cls) {
  const auto make = [](const Matrix& phi, const Triple& y, std::int64_t k) {
    return Sample{{matrix_of(phi), {y[0], y[1], y[2]}}, k};
  };
  const auto phi = [](const Sample& self) { return values_of(self.regression.phi); };
  const auto y = [](const Sample& self) {
    const auto& outputs = self.regression.y;
    return Triple{outputs[0], outputs[1], outputs[2]};
  };
  const Fields fields(make, Field("phi", phi), Field("y", y), Field("k", &Sample::k));
  define_equality(cls, fields);
  define_hash(cls, fields);
  define_pickle(cls, fields);
}

void define_observation_value(Class<Arrived>& cls) {
  const auto make = [](const std::optional<Frame>& frame, const std::optional<double>& t,
                       const std::optional<Pair>& last_u,
                       const std::optional<Measurement>& measurement,
                       const std::optional<Sample>& sample, bool interrupted) {
    Arrived arrived{frame, t, {}};
    if (last_u) arrived.known.last_u = input_of(*last_u);
    arrived.known.measurement = measurement;
    arrived.known.sample = sample;
    arrived.known.interrupted = interrupted;
    return arrived;
  };
  const auto last_u = [](const Arrived& self) {
    const std::optional<Input>& u = self.known.last_u;
    return u ? std::optional(pair_of(*u)) : std::nullopt;
  };
  const Fields fields(
      make, Field("frame", &Arrived::frame), Field("t", &Arrived::t), Field("last_u", last_u),
      Field("measurement", [](const Arrived& self) { return self.known.measurement; }),
      Field("sample", [](const Arrived& self) { return self.known.sample; }),
      Field("interrupted", [](const Arrived& self) { return self.known.interrupted; }));
  define_equality(cls, fields);
  define_hash(cls, fields);
  define_pickle(cls, fields);
}

void bind_estimate_and_sample(py::module_& module) {
  Class<Estimate> estimate(public_in(module, "robsim"), "Estimate", R"(
What a state estimator makes of a step.

Parameters
----------
pose : array (3,)
    x, y (work-area px), heading (rad).
covariance : array (3, 3)
    Its covariance.
state : array (n,), optional
    Any further state, n the same at every step.
)");
  estimate
      .def(py::init(&make_estimate), py::arg("pose"), py::arg("covariance"),
           py::arg("state") = py::none())
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
      .def("__repr__", py::overload_cast<const Estimate&>(&repr));
  define_estimate_value(estimate);

  Class<Sample> sample(public_in(module, "robsim.estimation"), "Sample", R"(
One sample for the parameter estimator: y = sum(phi * theta, axis=1).

Parameters
----------
phi : array (3, 5)
    Regressors of the axes X, Y and P (heading).
y : array (3,)
    Outputs x, y (work-area px) and heading (rad).
k : int
    The step whose output y is.
)");
  sample
      .def(py::init([](const ArrayLike& phi, const ArrayLike& y, std::int64_t k) {
             check_step_number(k);
             const Pose outputs = pose_from(y, "y");
             return Sample{{axis_matrix_from(phi, "phi"), {outputs.x, outputs.y, outputs.heading}},
                           k};
           }),
           py::arg("phi"), py::arg("y"), py::arg("k"))
      .def_readonly("k", &Sample::k, "int: the step whose output y is.")
      .def_property_readonly(
          "phi", [](const Sample& self) { return bindings::to_array(self.regression.phi); },
          "array (3, 5): regressors of the axes X, Y and P (heading).")
      .def_property_readonly(
          "y", [](const Sample& self) { return bindings::to_array(self.regression.y.data(), {3}); },
          "array (3,): outputs x, y (work-area px) and heading (rad).")
      .def("__repr__",
           [](const Sample& self) { return "<Sample of step " + std::to_string(self.k) + ">"; });
  define_sample_value(sample);
}

void bind_observation(py::module_& module) {
  Class<Arrived> observation(public_in(module, "robsim"), "Observation", R"(
What a source of frames may give to an `Experiment` in place of a plain frame.

Parameters
----------
frame : Frame, optional
    What the camera sees. None = no frame in this step.
t : float, optional
    Time of the step (s). Default: that of the frame, or one sample time after the last step.
last_u : array (2,), optional
    The input that the robot really got since the last step (V), if it is not what the controller
    returned.
measurement : Measurement or array (3,), optional
    Where the robot was seen, if somebody else has measured it: ``measure=True`` leaves it as it is.
sample : Sample, optional
    The sample for the parameter estimator, if somebody else has made it.
interrupted : bool
    The robot was stopped since the last step: no sample spans that.
)");
  observation
      .def(py::init(&make_observation), py::arg("frame") = py::none(), py::kw_only(),
           py::arg("t") = py::none(), py::arg("last_u") = py::none(),
           py::arg("measurement") = py::none(), py::arg("sample") = py::none(),
           py::arg("interrupted").noconvert() = false)
      .def_readonly("frame", &Arrived::frame, "Frame or None: what the camera sees.")
      .def_readonly("t", &Arrived::t, "float or None: time of the step (s).")
      .def_property_readonly(
          "last_u",
          [](const Arrived& self) -> std::optional<py::array_t<double>> {
            if (!self.known.last_u) return std::nullopt;
            return to_array(*self.known.last_u);
          },
          "array (2,) or None: the input since the last step (V).")
      .def_property_readonly(
          "measurement", [](const Arrived& self) { return self.known.measurement; },
          "Measurement or None: where the robot was seen.")
      .def_property_readonly(
          "sample", [](const Arrived& self) { return self.known.sample; },
          "Sample or None: the sample for the parameter estimator.")
      .def_property_readonly(
          "interrupted", [](const Arrived& self) { return self.known.interrupted; },
          "bool: the robot was stopped since the last step.")
      .def("__repr__", [](const Arrived& self) {
        return std::string("<Observation ") + (self.frame ? "with" : "without") + " a frame>";
      });
  define_observation_value(observation);
}

}  // namespace

void bind_records(py::module_& module) {
  bind_estimate_and_sample(module);
  bind_observation(module);
}
