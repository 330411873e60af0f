#include <cmath>

#include "python/callbacks.hpp"
#include "python/values.hpp"

using namespace robsim;
using namespace robsim::bindings;

namespace {

// A step may be looked at unless another thread is just filling it.
const Step& readable(const Step& step) {
  step.check_thread();
  return step;
}

Input decided_input(const Step& step) {
  if (readable(step).u) return *step.u;
  throw std::runtime_error("step.u, the input of step " + std::to_string(step.k) +
                           ", is not decided yet: the controller comes last. The input of the "
                           "step before is step.last_u");
}

// The camera of a step that is kept: always the same frame.
class KeptFrame : public Camera {
 public:
  explicit KeptFrame(Frame frame) : frame_(std::move(frame)) {}
  Frame frame() override { return frame_; }

 private:
  Frame frame_;
};

using Vision = std::tuple<std::vector<ColorClass>, MarkerLayout, std::optional<int>>;

// A step outside of any run. `had_frame`: one had come, even if it is not kept.
std::shared_ptr<Step> new_step(const std::optional<Frame>& frame, bool had_frame,
                               const std::optional<Vision>& vision) {
  std::shared_ptr<MarkerVision> marker_vision;
  if (vision) {
    marker_vision = std::make_shared<MarkerVision>(std::make_from_tuple<MarkerVision>(*vision));
  }
  auto step = std::make_shared<Step>(std::make_shared<RunGuard>(), marker_vision);
  step->begin(frame ? std::make_shared<KeptFrame>(*frame) : nullptr);
  step->has_frame = had_frame;
  return step;
}

using FrameOfStep =
    std::pair<bool, std::optional<Frame>>;  // whether one had come, the frame if it still exists
// The frame is drawn for a copy, if it still can be.
FrameOfStep frame_of(const Step& self) {
  auto& step = const_cast<Step&>(self);  // it is made on first use
  if (!step.can_look() || step.given >= Given::blobs) return {step.has_frame, std::nullopt};
  const Frame* frame = step.look();
  return {step.has_frame, frame ? std::optional(*frame) : std::nullopt};
}

std::optional<Vision> vision_of(const Step& step) {
  if (!step.marker_vision()) return std::nullopt;
  const MarkerVision& vision = *step.marker_vision();
  return Vision{vision.colors(), vision.markers(), vision.smoothing()};
}

// The fields of a step, but its frame and its vision.
template <typename Make, typename... More>
auto fields_of_step(const Make& make, const More&... more) {
  const auto read = [](auto Step::* member) {
    return [member](const Step& self) { return readable(self).*member; };
  };
  // The first look makes it.
  const auto sample = [](const Step& self) {
    return readable(self).gives_sample ? const_cast<Step&>(self).find_sample() : std::nullopt;
  };
  const auto detection = [](const Step& self) {
    return readable(self).given == Given::all ? self.detection : std::nullopt;
  };
  return Fields(
      make, Field("k", &Step::k, "int: number of the step, from 0."),
      Field("t", &Step::t, "float: time (s)."),
      Field("dt", &Step::dt,
            "float: time since the previous step (s); if the robot was stopped in "
            "between,\nrounded to sample times of the model."),
      Field("last_u", read(&Step::last_u),
            "array (2,): the input of the previous step, u1 left and u2 right (V)."),
      Field("u", &Step::u),
      Field("sample", sample,
            "Sample or None: the newest complete sample. It is None at the start, and if a bounce "
            "or a\nmissing measurement interrupts the record."),
      Field("parameters", read(&Step::parameters),
            "array (3, 5) or None: the parameters estimated so far."),
      Field("measurement", read(&Step::measurement),
            "Measurement or None: the measured pose. None before the measurement."),
      Field("detection", detection,
            "Detection or None: the result of the default measurement, also with the reason for a "
            "missing\npose. None before the measurement, in a step without a frame, and if a "
            "callback measures the\npose."),
      Field("estimate", read(&Step::estimate),
            "Estimate or None: the result of the state estimator."),
      more...);
}

std::shared_ptr<Step> step_from(std::int64_t k, double t, double dt, const Input& last_u,
                                const std::optional<Input>& u, const std::optional<Sample>& sample,
                                const std::optional<ArrayLike>& parameters,
                                const std::optional<Measurement>& measurement,
                                const std::optional<Detection>& detection,
                                const std::optional<Estimate>& estimate, const FrameOfStep& frame,
                                const std::optional<Vision>& vision) {
  const std::shared_ptr<Step> step = new_step(frame.second, frame.first, vision);
  step->k = k;
  step->t = t;
  step->dt = dt;
  step->last_u = last_u;
  step->u = u;
  step->set_sample(sample);
  if (parameters) {
    const Doubles theta = numbers_from(*parameters, "parameters", Shape{3, 5}, "theta");
    step->parameters = Eigen::Map<const AxisMatrix>(theta.data());
  }
  step->measurement = measurement;
  step->detection = detection;
  step->estimate = estimate;
  return step;
}

std::shared_ptr<Step> make_step(std::int64_t k, std::optional<double> t, double dt,
                                const Input& last_u, const std::optional<Frame>& frame,
                                const std::optional<MeasurementLike>& measurement,
                                const std::optional<Estimate>& estimate,
                                const std::optional<AxisMatrix>& parameters,
                                const std::optional<Sample>& sample, const std::optional<Input>& u,
                                const std::vector<ColorClass>& colors,
                                const std::optional<MarkerLayout>& markers) {
  check_step_number(k);
  if (!(dt > 0 && std::isfinite(dt))) throw py::value_error("dt must be above 0 s and finite");
  if (t && !std::isfinite(*t)) throw py::value_error("t must be finite (s)");
  const auto vision =
      markers ? std::optional(Vision{colors, *markers, std::nullopt}) : std::nullopt;
  const std::shared_ptr<Step> step =
      step_from(k, t.value_or(static_cast<double>(k) * dt), dt, last_u, u, sample, std::nullopt,
                measurement, std::nullopt, estimate, {frame.has_value(), frame}, vision);
  step->parameters = parameters;
  return step;
}

}  // namespace

void bind_steps(py::module_& module) {
  Class<Step, std::shared_ptr<Step>> step(public_in(module, "robsim"), "Step", R"(
The data of a step for the robot's software, read-only. Each stage adds its result.

A step that you create yourself can test a callback without a simulation. A copy contains the frame,
if it still exists, but no `estimator`. Steps with the same numbers are equal; frames are not
compared.

Parameters
----------
k : int
    Number of the step.
t : float, optional
    Time (s). Default: k dt.
dt : float
    Time since the previous step (s).
last_u : array (2,)
    The input of the previous step (V).
frame : Frame, optional
    What the camera sees.
measurement : Measurement or array (3,), optional
    Where the robot was seen.
estimate : Estimate, optional
    The result of the state estimator.
parameters : array (3, 5), optional
    The estimated parameters.
sample : Sample, optional
    The sample for the parameter estimator.
u : array (2,), optional
    The input of this step (V).
colors : list of ColorClass
    The colours used to find `blobs`.
markers : MarkerLayout, optional
    The robot's markers and their positions.

Examples
--------
>>> step = robsim.Step(k=3, measurement=(600, 500, 0.1))
>>> [round(float(u), 3) for u in robsim.GoToPoint(900, 300)(step)]
[0.037, 1.0]
)");
  const RobotParameters defaults;
  const auto numbers = fields_of_step([] { return std::shared_ptr<Step>(); });
  define_properties(step, numbers);
  step.def(py::init(&make_step), py::kw_only(), "k"_a = 0, "t"_a = py::none(), "dt"_a = defaults.dt,
           "last_u"_a = std::make_tuple(0.0, 0.0), "frame"_a = py::none(),
           "measurement"_a = py::none(), "estimate"_a = py::none(), "parameters"_a = py::none(),
           "sample"_a = py::none(), "u"_a = py::none(), "colors"_a = std::vector<ColorClass>(),
           "markers"_a = py::none())
      .def_property_readonly("u", &decided_input,
                             "array (2,): the input of this step, as sent to the motors (V). "
                             "RuntimeError before the controller.")
      .def_property_readonly(
          "frame",
          [](Step& self) -> std::optional<Frame> {
            const Frame* frame = self.given_frame();
            return frame ? std::optional(*frame) : std::nullopt;
          },
          "Frame or None: the camera's frame. None if no frame came in this step.")
      .def_property_readonly(
          "blobs", [](Step& self) { return self.given_blobs(); },
          "dict of str to list of Blob: per colour the blobs in the frame, the largest first.")
      .def_property_readonly(
          "estimator", [](const Step& self) { return to_python(self.estimator); },
          "The object from init_parameter_estimator.")
      .def_property_readonly(
          "markers", [](const Step& self) { return self.markers(); },
          "MarkerLayout: the robot's markers and their positions.")
      .def_property_readonly(
          "colors", [](const Step& self) { return self.colors(); },
          "list of ColorClass: the colours used to find blobs.");
  define_repr(step, "<Step {0.k}: t = {0.t:g} s>");
  // Equal are steps with the same numbers. It fills up during the step: there is no hash.
  define_equality(step, numbers);
  define_pickle(step,
                fields_of_step(&step_from, Field("frame", &frame_of), Field("vision", &vision_of)));
}
