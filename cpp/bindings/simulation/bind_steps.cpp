#include <pybind11/stl.h>

#include <cmath>

#include "python/callbacks.hpp"
#include "python/numpy.hpp"
#include "python/public_names.hpp"
#include "robsim/simulation/world/external_world.hpp"

namespace py = pybind11;
using namespace robsim;
using namespace robsim::bindings;

namespace {

// A step may be looked at unless another thread is just filling it.
const Step& readable(const Step& step) {
  step.check_thread();
  return step;
}

py::array_t<double> input_of(const Step& step) {
  if (readable(step).u) return to_array(*step.u);
  throw std::runtime_error("step.u, the input of step " + std::to_string(step.k) +
                           ", is not decided yet: the controller comes last. The input of the "
                           "step before is step.last_u");
}

Arrived make_observation(const std::optional<Frame>& frame, const std::optional<double>& t,
                         const py::object& last_u, const py::object& measurement,
                         const std::optional<Sample>& sample) {
  Arrived arrived;
  arrived.frame = frame;
  if (t && !std::isfinite(*t)) throw py::value_error("t must be finite (s)");
  arrived.t = t;
  if (!last_u.is_none()) arrived.known.last_u = input_from(last_u, "last_u");
  if (py::isinstance<Measurement>(measurement)) {
    arrived.known.measurement = measurement.cast<Measurement>();
  } else if (!measurement.is_none()) {
    arrived.known.measurement = Measurement{pose_from(measurement, "measurement")};
  }
  arrived.known.sample = sample;
  return arrived;
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

Parameters
----------
phi : array (3, 5)
    Regressors of the axes X, Y and P (heading).
y : array (3,)
    Outputs x, y (work-area px) and heading (rad).
k : int
    The step whose output y is.
)")
      .def(py::init([](const py::object& phi, const py::object& y, std::int64_t k) {
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
}

void bind_observation(py::module_& module) {
  py::class_<Arrived>(public_in(module, "robsim"), "Observation", R"(
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
)")
      .def(py::init(&make_observation), py::arg("frame") = py::none(), py::kw_only(),
           py::arg("t") = py::none(), py::arg("last_u") = py::none(),
           py::arg("measurement") = py::none(), py::arg("sample") = py::none())
      .def_readonly("frame", &Arrived::frame, "Frame or None: what the camera sees.")
      .def_readonly("t", &Arrived::t, "float or None: time of the step (s).")
      .def_property_readonly(
          "last_u",
          [](const Arrived& self) -> py::object {
            if (!self.known.last_u) return py::none();
            return to_array(*self.known.last_u);
          },
          "array (2,) or None: the input since the last step (V).")
      .def_property_readonly(
          "measurement", [](const Arrived& self) { return self.known.measurement; },
          "Measurement or None: where the robot was seen.")
      .def_property_readonly(
          "sample", [](const Arrived& self) { return self.known.sample; },
          "Sample or None: the sample for the parameter estimator.")
      .def("__repr__", [](const Arrived& self) {
        return std::string("<Observation ") + (self.frame ? "with" : "without") + " a frame>";
      });
}

void bind_step(py::module_& module) {
  py::class_<Step, std::shared_ptr<Step>>(public_in(module, "robsim"), "Step", R"(
What the robot half may know of a step, read-only. It fills up from stage to stage.
)")
      .def_readonly("k", &Step::k, "int: number of the step, from 0.")
      .def_readonly("t", &Step::t, "float: time (s).")
      .def_readonly("dt", &Step::dt,
                    "float: time since the step before (s); if the robot was stopped in between,\n"
                    "rounded to sample times of the model.")
      .def_property_readonly(
          "last_u", [](const Step& self) { return to_array(readable(self).last_u); },
          "array (2,): the input of the step before, u1 left and u2 right (V).")
      .def_property_readonly("u", &input_of,
                             "array (2,): the input decided in this step, as sent to the motors "
                             "(V). RuntimeError before that.")
      .def_property_readonly(
          "frame",
          [](Step& self) -> std::optional<Frame> {
            const Frame* frame = self.look();
            return frame ? std::optional(*frame) : std::nullopt;
          },
          "Frame or None: what the camera sees. None if no frame came in this step.")
      .def_property_readonly(
          "blobs", [](Step& self) { return self.find_blobs(); },
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
      .def_property_readonly(
          "markers", [](const Step& self) { return self.markers(); },
          "MarkerLayout: where the robot carries its markers.")
      .def("__repr__", [](const Step& self) { return "<Step " + std::to_string(self.k) + ">"; });
}

}  // namespace

void bind_steps(py::module_& module) {
  bind_records(module);
  bind_observation(module);
  bind_step(module);
}
