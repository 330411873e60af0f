#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "python/by_role.hpp"
#include "python/values.hpp"
#include "robsim/simulation/robot/robot_software.hpp"
#include "robsim/simulation/seam/thread_guard.hpp"
#include "robsim/vision/color/image_statistics.hpp"
#include "robsim/vision/explain_detection.hpp"
#include "robsim/vision/marker_vision.hpp"
#include "robsim/vision/marker_width.hpp"

using namespace robsim;
using namespace robsim::bindings;

namespace {

using BlobPair = py::typing::Dict<py::str, Blob>;

BlobPair blobs_of(MarkerRoles roles, const Blob& first, const Blob& second) {
  return by_role<Blob>(roles, py::cast(first), py::cast(second));
}

MarkerPair pair_from(const ByRole<Blob>& blobs) {
  const MarkerRoles roles = roles_of(blobs, "seen");
  const auto [first, second] = in_order(blobs, roles, "seen");
  return {first, second, roles};
}

// Symmetric, and no combination of x, y and heading with a variance below 0.
void check_covariance(const PoseCovariance& P) {
  const auto refuse = [&](const char* must) {
    throw py::value_error(std::string("covariance must be ") + must + ", got " +
                          describe(to_array(P).attr("tolist")()));
  };
  const Eigen::Vector3d deviations = P.diagonal().cwiseSqrt();
  const Eigen::Array33d limits = deviations * deviations.transpose();
  const Eigen::Array33d covariances = P.array();
  if (((covariances - covariances.transpose()).abs() > 1e-6 * limits).any() ||
      (covariances.abs() > limits * (1 + 1e-9)).any()) {
    refuse("symmetric, with correlations between -1 and 1");
  }
  const Eigen::Matrix3d correlations =
      (limits > 0).select(covariances / limits, Eigen::Array33d(Eigen::Matrix3d::Identity()));
  if (correlations.determinant() < -1e-6) refuse("positive semidefinite");
}

double at_least_0(double value, const char* name) {
  if (value >= 0 && std::isfinite(value)) return value;
  throw py::value_error(std::string(name) + " must be finite and at least 0, got " +
                        describe(py::float_(value)));
}

Measurement make_measurement(const ArrayLike& pose, const std::optional<PoseCovariance>& covariance,
                             std::optional<double> misfit, std::optional<double> signal_to_noise,
                             const std::optional<ByRole<Blob>>& pair) {
  Measurement measurement = measured_pose_from(pose, "pose");
  if (covariance) check_covariance(*covariance);
  measurement.covariance = covariance;
  if (misfit) measurement.misfit = at_least_0(*misfit, "misfit");
  if (signal_to_noise)
    measurement.signal_to_noise = at_least_0(*signal_to_noise, "signal_to_noise");
  if (pair) measurement.pair = pair_from(*pair);
  return measurement;
}

// The pose, how exact it is, and how far it stands out of the noise, as far as that is known.
py::str repr_of_measurement(const Measurement& self) {
  const bool has_signal = !std::isnan(self.signal_to_noise);
  if (!self.covariance && !has_signal) {
    return py::str("Measurement({})").format(to_array(self.pose).attr("tolist")());
  }
  std::string text = "<Measurement: x {0:.2f} px, y {1:.2f} px, heading {2:.4f} rad";
  if (self.covariance) text += "; +- {3:.2g} px, {4:.2g} px, {5:.2g} rad";
  if (has_signal) text += "; signal to noise {6:.3g}";
  const PoseCovariance covariance = self.covariance.value_or(PoseCovariance::Zero());
  const Eigen::Vector3d sd = covariance.diagonal().cwiseSqrt();
  return py::str(text + ">")
      .format(self.pose.x, self.pose.y, self.pose.heading, sd[0], sd[1], sd[2],
              self.signal_to_noise);
}

void bind_measurement(py::module_& module) {
  Class<Measurement> measurement(public_in(module, "robsim"), "Measurement", R"(
The pose of a detected robot, and its accuracy. A frame without a detection gives None instead.

Parameters
----------
pose : array (3,)
    x, y (work-area px), heading (rad, not degrees). The heading is wrapped to (-pi, pi].
covariance : array (3, 3), optional
    Of x, y (work-area px) and heading (rad). Default: not known.
misfit : float, optional
    Factor on the variance, because the residuals of the markers' fit contain more than noise: 1 =
    only noise. In frames without noise the rendering causes a misfit of up to 2. A larger misfit
    means that the markers differ from their outlines: they are moved, compressed or partly hidden.
    The `misfit` of a `Detection` is a different number, which refers to the pair of blobs.
signal_to_noise : float, optional
    Ratio of the markers' edges to the noise. A pose is reliable if the ratio is at least 4; below 3
    no pose is reported.
seen : dict of str to Blob, optional
    The seen markers of the robot, by role, ``"right"`` and ``"left"``, or ``"front"`` and
    ``"back"``: for a `BlobMarker` its blob. Its colour is its identity.

Raises
------
ValueError
    If the pose is not finite, if the covariance is invalid, or if a figure is below 0 or not
    finite.

Examples
--------
>>> noise = robsim.GaussianNoise(10)
>>> sim = robsim.Simulation(measure=True, headings=None, noise=noise, seed=1)
>>> np.sqrt(np.diag(sim.step().measurement.covariance)).round(2)  # px, px, rad
array([0.03, 0.04, 0.  ])
)");
  const Fields fields(
      &make_measurement,
      Field("pose", &Measurement::pose,
            "array (3,): x, y (work-area px), heading (rad, in (-pi, pi])."),
      by_name,
      Field(
          "covariance", &Measurement::covariance,
          "array (3, 3) or None: covariance of x, y (work-area px) and heading (rad); None = not\n"
          "known.",
          std::nullopt),
      Field(
          "misfit", [](const Measurement& self) { return known(self.misfit); },
          "float or None: factor on the variance, 1 if the fit's residuals are only noise.",
          std::nullopt),
      Field(
          "signal_to_noise", [](const Measurement& self) { return known(self.signal_to_noise); },
          "float or None: ratio of the markers' edges to the noise; from 4 on a pose is reliable.",
          std::nullopt),
      Field(
          "seen",
          [](const Measurement& self) -> std::optional<BlobPair> {
            if (!self.pair) return std::nullopt;
            return blobs_of(self.pair->roles, self.pair->first, self.pair->second);
          },
          "dict of str to Blob or None: the markers' blobs, by role.", std::nullopt));
  define_value(measurement, fields);
  measurement.def("__repr__", &repr_of_measurement);
}

py::str repr(const Detection& self) {
  const py::str found =
      self.measurement ? py::repr(py::cast(*self.measurement)) : py::str("none, " + name_of(self));
  return py::str("<Detection: {}, misfit of the pair {:.3g}>").format(found, self.misfit);
}

void bind_detection(py::module_& module) {
  Class<Detection> detection(public_in(module, "robsim.vision"), "Detection", R"(
The result of `detect`: the pair of blobs that fits the markers best, its misfit, and its pose.

The misfit is the sum of three squared deviations. The deviation of the distance is divided by the
markers' ``distance_tolerance``. The deviations of the logarithms of the two areas are divided by
the logarithm of ``area_tolerance``. In an accepted pair, each squared deviation is at most 1.

Examples
--------
>>> markers = robsim.load_robot("lab").marker_layout()
>>> robsim.vision.detect({"red": [], "blue": []}, markers).reason
'no blobs'
)");
  detection
      .def_property_readonly(
          "seen",
          [](const Detection& self) -> std::optional<BlobPair> {
            if (!self.first || !self.second) return std::nullopt;
            return blobs_of(self.markers.roles, *self.first, *self.second);
          },
          "dict of str to Blob or None: the markers' blobs, by role; if no pair is accepted,\nthe "
          "most similar blobs.")
      .def_property_readonly(
          "distance",
          [](const Detection& self) {
            return self.first ? self.distance : std::numeric_limits<double>::quiet_NaN();
          },
          "float: distance between the two blobs (work-area px); NaN without a pair.")
      .def_property_readonly(
          "reason",
          [](const Detection& self) {
            return self.measurement ? std::nullopt : std::optional(name_of(self));
          },
          "str or None: reason for a missing measurement: ``\"no blobs\"``, ``\"no red "
          "blob\"``,\n``\"no blue blob\"`` or other colours' names, ``\"at the border\"``, "
          "``\"distance\"``,\n``\"areas\"``, ``\"ambiguous\"``, ``\"by chance\"``, ``\"noise\"`` "
          "or ``\"shape\"``. If the frame\nshows the cause, the reason is ``\"dark\"``, "
          "``\"overexposed\"`` or ``\"small markers\"``.")
      .def_property_readonly("explanation", &explain,
                             "str: a sentence on the result, with the decisive numbers.")
      .def("__repr__", &repr);
  define_record(
      detection,
      members<Detection>(
          nullptr,
          Field("measurement", &Detection::measurement,
                "Measurement or None: None = not detected, see `reason`."),
          Field("result", &Detection::result), Field("first", &Detection::first),
          Field("second", &Detection::second),
          Field("misfit", &Detection::misfit,
                "float: misfit of the pair, from 0 = perfect; inf without a pair. The misfit of "
                "the fit to\nthe edges is in the measurement."),
          Field("runner_up", &Detection::runner_up,
                "float: misfit of the second best accepted pair; inf without such a pair. If the "
                "value is\nclose to the misfit, the choice is ambiguous."),
          Field("exchanged", &Detection::exchanged), Field("distance", &Detection::distance),
          Field("first_area", &Detection::first_area),
          Field("second_area", &Detection::second_area),
          Field("false_alarms", &Detection::false_alarms,
                "float: expected number of pairs of the other blobs that fit as well by chance, "
                "for random\npositions; a pair is accepted up to 0.005."),
          Field("cause", &Detection::cause), Field("noise", &Detection::noise),
          Field("by_second_chance", &Detection::by_second_chance,
                "bool: the pair was found only with colours relative to brightness. The limits of "
                "a colour\nthen apply to U - 128 and V - 128, divided by the largest of R, G and "
                "B. A limit of 26\nlevels is a saturation of 29 %. Under coloured light, the floor "
                "is taken as grey. Dim or\nuneven light and faded markers change the levels, but "
                "not the fractions."),
          Field("markers", &Detection::markers)));

  Class<MissedDetections> missed(public_in(module, "robsim.vision"), "MissedDetections", R"(
The steps of a run in which the default measurement detected no robot, for the same reason.

Examples
--------
>>> sim = robsim.Simulation(measure=True, area=(200, 200), start=(5, 100, 0), seed=1)
>>> sim.run(3).seen.any()
np.False_
>>> [(missed.reason, missed.steps) for missed in sim.missed_detections]
[('at the border', 3)]
)");
  missed
      .def_property_readonly(
          "reason", [](const MissedDetections& self) { return name_of(self.first); },
          "str: the reason, as in `Detection`.")
      .def_readonly("steps", &MissedDetections::steps, "int: number of these steps.")
      .def_readonly("first_k", &MissedDetections::first_k, "int: the first of these steps.")
      .def_readonly("first", &MissedDetections::first, "Detection: in the first step.");
  define_repr(missed,
              "<MissedDetections: {0.reason} in {0.steps} steps, first in step {0.first_k}>");
}

// With a Frame's plane map, if no other one is given.
Detection detect_in(const BlobsByColor& blobs, const MarkerLayout& markers,
                    const std::optional<PlaneMap>& plane_map, const std::optional<ImageLike>& image,
                    const std::optional<std::vector<ColorClass>>& colors) {
  if (colors && !image) throw py::value_error("colors must come with an image, got no image");
  if (!image) return detect(blobs, markers, plane_map.value_or(PlaneMap()));
  Frame frame;
  if (image->frame) {
    frame = *image->frame;
  } else {
    frame.image = {image->view, nullptr};
  }
  if (plane_map) frame.plane_map = *plane_map;
  const NativeWork work(std::int64_t{frame.image.width()} * frame.image.height());
  return detect(blobs, markers, frame, colors.value_or(std::vector<ColorClass>()));
}

std::optional<Measurement> locate_in(const BlobsByColor& blobs, const MarkerLayout& markers,
                                     const std::optional<PlaneMap>& plane_map,
                                     const std::optional<ImageLike>& image,
                                     const std::optional<std::vector<ColorClass>>& colors) {
  return detect_in(blobs, markers, plane_map, image, colors).measurement;
}

std::vector<std::string> reasons(const std::array<std::string, 2>& colors) {
  MarkerLayout markers;
  markers.first.color = colors[0];
  markers.second.color = colors[1];
  std::vector<std::string> names;
  for (int i = 1; i <= static_cast<int>(last_result); ++i) {
    names.push_back(name_of(static_cast<DetectionResult>(i), markers));
  }
  return names;
}

double noise_of(const Frame& frame) { return grey_noise(frame.image.view()); }

void bind_functions(py::module_& module) {
  public_in(module, "robsim.vision")
      .def("detect", &detect_in, "blobs"_a, "markers"_a, py::kw_only(), "plane_map"_a = py::none(),
           "image"_a = py::none(), "colors"_a = py::none(), R"(
Search the blobs for the markers of a robot; report the misfit, or the reason for a missing pair.

The pair has a blob of each of the two colours, and is chosen based on the blobs' distance and
areas. Blobs at the border of the frame are not used, because they may be cut off. Noise and other
objects may cause many blobs that resemble the markers. A pair is then accepted only if a pair of
other blobs would rarely fit as well by chance [1]_. So if the floor shows only noise, a pose is
reported in at most one or two of 100 frames.

Parameters
----------
blobs : dict of str to list of Blob
    From `find_blobs`; the two `MarkerLayout.colors` are used.
markers : MarkerLayout
    The positions of the markers on the robot.
plane_map : PlaneMap, optional
    Map from pixels of the blobs' frame to the work area. Default: the map of `image`, if it is a
    Frame; otherwise the identity.
image : Frame or array (H, W, 3) of uint8, optional
    The image of the blobs. With an image the pose is fitted to the edges of the markers, as in
    `locate`. Without a measurement the image is examined for the cause, such as darkness.
colors : list of ColorClass, optional
    The colours used to find the blobs. With colours and the image, a frame without a pair gets a
    second chance, as in the default measurement: the search is repeated with the same colours
    relative to brightness, see `Detection.by_second_chance`.

Returns
-------
Detection
    Its measurement, misfit and reason.

Raises
------
TypeError, ValueError
    For an image of the wrong type or shape, and for `colors` without an image.

References
----------
.. [1] A. Desolneux, L. Moisan, J.-M. Morel, "Meaningful alignments", International Journal of
   Computer Vision 40 (2000): the number of false alarms.

Examples
--------
>>> frame = robsim.Simulation(seed=1).step().frame
>>> blobs = robsim.find_blobs(frame, robsim.load_colors())
>>> detection = robsim.vision.detect(blobs, robsim.load_robot("lab").marker_layout())
>>> detection.explanation
'red and blue blobs 43.0 px of the work area apart fit the markers (misfit 0.01)'
)");

  public_in(module, "robsim._core")
      .def("detection_reasons", &reasons, "colors"_a = default_marker_colors,
           "The reasons of a Detection, in the order of their numbers from 1.")
      .def("frame_noise", &noise_of, "frame"_a,
           "Standard deviation of the noise of a frame's channels (grey levels).")
      .def("expected_signal_to_noise", &expected_signal_to_noise, "width"_a, "noise"_a,
           "The signal-to-noise figure of markers of a width (frame px) at a noise (grey levels), "
           "in\ngood light.")
      .def("trusted_width", &trusted_width, "noise"_a,
           "Smallest reliable width of markers (frame px) at a noise (grey levels).")
      .def("small_markers_remark", &small_markers_remark, "width"_a, "noise"_a,
           "A remark on markers too small for the noise; None for large enough ones.");

  public_in(module, "robsim")
      .def("locate", &locate_in, "blobs"_a, "markers"_a, "plane_map"_a = py::none(), py::kw_only(),
           "image"_a = py::none(), "colors"_a = py::none(), R"(
Return the pose of the robot whose markers are among the blobs.

The pair has a blob of each of the two colours, and is chosen based on the blobs' distance and
areas. Blobs at the border of the frame are not used, because they may be cut off. With the image,
the pose is then fitted to the pixels around the edges of the markers, by weighted least squares
[1]_. The error is then half to two thirds of the centroids' error with noise, and a fifth without
noise. For markers with unknown outlines, pixels at the edge are weighted by their colour.

Parameters
----------
blobs : dict of str to list of Blob
    From `find_blobs`; the two `MarkerLayout.colors` are used.
markers : MarkerLayout
    The positions of the markers on the robot; from `MarkerLayout.from_markers` also their outlines.
plane_map : PlaneMap, optional
    Map from pixels of the blobs' frame to the work area. Default: the map of `image`, if it is a
    Frame; otherwise the identity.
image : Frame or array (H, W, 3) of uint8, optional
    The image of the blobs. By default, the pose comes from the blobs' centroids. Pass the Frame,
    ``step.frame``, not its pixels. An array has no plane map and no number of drawn headings, so
    the covariance would omit the rounding of the headings.
colors : list of ColorClass, optional
    The colours used to find the blobs: a frame without a pair then gets a second chance, as in
    `detect`.

Returns
-------
Measurement or None
    The pose; with the image, also its covariance, misfit and signal-to-noise ratio. None = not
    detected: no pair fits, two pairs fit equally well, or the markers are not distinguishable from
    the noise. `robsim.vision.detect` gives the reason.

References
----------
.. [1] R. Hartley, A. Zisserman, "Multiple View Geometry in Computer Vision", 2nd edition, 2003,
   appendix 6: Gauss-Newton iteration; chapter 5: its covariance.

Examples
--------
>>> frame = robsim.Simulation(headings=None, seed=1).step().frame
>>> blobs = robsim.find_blobs(frame, robsim.load_colors())
>>> markers = robsim.load_robot("lab").marker_layout()
>>> robsim.locate(blobs, markers, image=frame).pose.round(1) + 0.0  # px, px, rad
array([600., 600.,   0.])
)");
}

}  // namespace

void bind_locate(py::module_& module) {
  bind_measurement(module);
  bind_detection(module);
  bind_functions(module);
}
