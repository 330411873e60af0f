#include <pybind11/stl.h>

#include <array>
#include <limits>
#include <optional>
#include <string>

#include "python/numpy.hpp"
#include "python/public_names.hpp"
#include "python/values.hpp"
#include "robsim/simulation/robot/robot_software.hpp"
#include "robsim/vision/explain_detection.hpp"
#include "robsim/vision/frame_faults.hpp"

namespace py = pybind11;
using namespace robsim;
using namespace robsim::bindings;

namespace {

using Numbers = std::array<double, 3>;

Numbers numbers_of(const Measurement& measurement) {
  const Pose& pose = measurement.pose;
  return {pose.x, pose.y, pose.heading};
}

Measurement measurement_from(const Numbers& pose) { return {pose_from(py::cast(pose), "pose")}; }

void bind_measurement(py::module_& module) {
  Class<Measurement> measurement(public_in(module, "robsim"), "Measurement", R"(
The pose of a detected robot. A frame without a detection gives None instead.

Parameters
----------
pose : array (3,)
    x, y (work-area px), heading (rad, not degrees). The heading is wrapped to (-pi, pi].
)");
  measurement
      .def(py::init([](const ArrayLike& pose) { return Measurement{pose_from(pose, "pose")}; }),
           py::arg("pose"))
      .def_property_readonly(
          "pose", [](const Measurement& self) { return to_array(self.pose); },
          "array (3,): x, y (work-area px), heading (rad, in (-pi, pi]).");
  define_value(measurement, Fields(&measurement_from, Field("", &numbers_of)));
}

Detection detection_from(std::optional<Measurement> measurement, int result,
                         const std::optional<Blob>& red, const std::optional<Blob>& blue,
                         const std::array<double, 8>& numbers, const MarkerLayout& markers) {
  if (result < 0 || result > static_cast<int>(DetectionResult::small_markers)) {
    throw py::value_error("a Detection cannot be made of the result " + std::to_string(result));
  }
  Detection detection;
  detection.measurement = measurement;
  detection.result = static_cast<DetectionResult>(result);
  detection.red = red;
  detection.blue = blue;
  detection.misfit = numbers[0];
  detection.runner_up = numbers[1];
  detection.exchanged = numbers[2];
  detection.distance = numbers[3];
  detection.red_area = numbers[4];
  detection.blue_area = numbers[5];
  detection.false_alarms = numbers[6];
  detection.cause = numbers[7];
  detection.markers = markers;
  return detection;
}

auto detection_fields() {
  return Fields(
      &detection_from, Field("measurement", &Detection::measurement),
      Field("result", [](const Detection& self) { return static_cast<int>(self.result); }),
      Field("red", &Detection::red), Field("blue", &Detection::blue),
      Field("numbers",
            [](const Detection& self) {
              return std::array<double, 8>{self.misfit,       self.runner_up, self.exchanged,
                                           self.distance,     self.red_area,  self.blue_area,
                                           self.false_alarms, self.cause};
            }),
      Field("markers", &Detection::markers));
}

std::string repr(const Detection& self) {
  const std::string found = self.measurement
                                ? py::repr(py::cast(*self.measurement)).cast<std::string>()
                                : "none, " + name_of(self.result);
  return "<Detection: " + found + ", misfit " +
         py::str("{:.3g}").format(self.misfit).cast<std::string>() + ">";
}

void bind_detection(py::module_& module) {
  Class<Detection> detection(public_in(module, "robsim.vision"), "Detection", R"(
What `detect` found: the pair of blobs that fits the markers best, how well, and what follows.

The misfit is the sum of three squared deviations: of the distance, as a fraction of
``distance_tolerance`` of the markers, and of the logarithm of each area, as a fraction of that of
``area_tolerance``. In a pair that is accepted each is at most 1.
)");
  detection
      .def_readonly("measurement", &Detection::measurement,
                    "Measurement or None: None = not detected, see `reason`.")
      .def_readonly("red", &Detection::red,
                    "Blob or None: the red blob of the pair; if no pair is accepted, of the one "
                    "most\nlike the markers.")
      .def_readonly("blue", &Detection::blue, "Blob or None: the blue blob of the pair.")
      .def_readonly("misfit", &Detection::misfit,
                    "float: misfit of the pair, from 0 = perfect; inf without a pair.")
      .def_readonly("runner_up", &Detection::runner_up,
                    "float: misfit of the second best pair that is accepted; inf if there is none. "
                    "Near the\nmisfit, the choice is ambiguous.")
      .def_readonly("exchanged_misfit", &Detection::exchanged,
                    "float: misfit of the pair if the red blob were the blue marker, and the blue "
                    "blob the red\none: smaller in mirrored frames, if the areas of the markers "
                    "differ.")
      .def_readonly("false_alarms", &Detection::false_alarms,
                    "float: how many pairs of the other blobs would fit as well by chance, if they "
                    "lay\nanywhere; a pair is accepted up to 0.005.")
      .def_property_readonly(
          "distance",
          [](const Detection& self) {
            return self.red ? self.distance : std::numeric_limits<double>::quiet_NaN();
          },
          "float: distance between the two blobs (work-area px); NaN without a pair.")
      .def_property_readonly(
          "reason",
          [](const Detection& self) {
            return self.measurement ? std::nullopt : std::optional(name_of(self.result));
          },
          "str or None: why there is no measurement: ``\"no blobs\"``, ``\"no red blob\"``,\n"
          "``\"no blue blob\"``, ``\"at the border\"``, ``\"distance\"``, ``\"areas\"``,\n"
          "``\"ambiguous\"`` or ``\"by chance\"``; and, where the frame tells the cause, "
          "``\"dark\"``,\n``\"overexposed\"`` or ``\"small markers\"``.")
      .def_property_readonly("explanation", &explain,
                             "str: a sentence on the result, with the numbers that decided.")
      .def("__repr__", py::overload_cast<const Detection&>(&repr));
  const auto fields = detection_fields();
  define_equality(detection, fields);
  define_hash(detection, fields);
  define_pickle(detection, fields);

  Class<MissedDetections>(public_in(module, "robsim.vision"), "MissedDetections", R"(
The steps of a run in which the default measurement detected no robot, for the same reason.
)")
      .def_property_readonly(
          "reason", [](const MissedDetections& self) { return name_of(self.first.result); },
          "str: the reason, as in `Detection`.")
      .def_readonly("steps", &MissedDetections::steps, "int: number of these steps.")
      .def_readonly("first_k", &MissedDetections::first_k, "int: the first of these steps.")
      .def_readonly("first", &MissedDetections::first, "Detection: that of the first step.")
      .def("__repr__", [](const MissedDetections& self) {
        return "<MissedDetections: " + name_of(self.first.result) + " in " +
               std::to_string(self.steps) + " steps, first in step " +
               std::to_string(self.first_k) + ">";
      });
}

Detection detect_in(const BlobsByColor& blobs, const MarkerLayout& markers,
                    const PlaneMap& plane_map, const std::optional<ImageLike>& image) {
  Detection detection = detect(blobs, markers, plane_map);
  if (image) examine_frame(detection, view_from(*image, "image"), plane_map);
  return detection;
}

std::optional<std::string> remark_on_size(const MarkerLayout& markers, const Frame& frame) {
  return small_markers_remark(markers, frame.plane_map, frame.image.width(), frame.image.height());
}

void bind_functions(py::module_& module) {
  public_in(module, "robsim.vision")
      .def("detect", &detect_in, py::arg("blobs"), py::arg("markers"), py::kw_only(),
           py::arg("plane_map") = PlaneMap(), py::arg("image") = py::none(), R"(
Look for the markers of a robot among the blobs, and say how well they fit, or why they do not.

The red-blue pair is chosen by its distance and areas. Blobs at the border of the frame are not
used: they may be cut off. Where noise or other things give many blobs like the markers, a pair is
accepted only if hardly any pair of the others would fit as well by chance [1]_: on a floor of
noise, a pose is reported in one or two of 100 frames at most.

Parameters
----------
blobs : dict of str to list of Blob
    As from `find_blobs`; "red" and "blue" are used: names of the two markers, whatever their
    colours are.
markers : MarkerLayout
    The positions of the markers on the robot.
plane_map : PlaneMap, optional
    From pixels of the blobs' frame to the work area. Default: the identity.
image : Frame or array (H, W, 3) of uint8, optional
    Where the blobs were found: without a measurement it is examined for the cause, such as a dark
    picture.

Returns
-------
Detection
    Its measurement, misfit and reason.

References
----------
.. [1] A. Desolneux, L. Moisan, J.-M. Morel, "Meaningful alignments", International Journal of
   Computer Vision 40 (2000): the number of false alarms.

Examples
--------
>>> blobs = robsim.find_blobs(frame, robsim.load_colors())
>>> detection = robsim.vision.detect(blobs, robsim.load_robot("lab").marker_layout())
>>> detection.reason, detection.explanation
)");

  public_in(module, "robsim._core")
      .def("small_markers_remark", &remark_on_size, py::arg("markers"), py::arg("frame"),
           "What is to be said of markers too small in the frame; None of others.");

  public_in(module, "robsim")
      .def("locate", &locate, py::arg("blobs"), py::arg("markers"),
           py::arg("plane_map") = PlaneMap(), R"(
Return the pose of the robot whose markers are among the blobs.

The red-blue pair is chosen by its distance and areas. Blobs at the border of the frame are not
used: they may be cut off.

Parameters
----------
blobs : dict of str to list of Blob
    As from `find_blobs`; "red" and "blue" are used.
markers : MarkerLayout
    The positions of the markers on the robot.
plane_map : PlaneMap, optional
    From pixels of the blobs' frame to the work area. Default: the identity.

Returns
-------
Measurement or None
    None = not detected: no pair fits, or two fit equally well. `robsim.vision.detect` says why.
)");
}

}  // namespace

void bind_locate(py::module_& module) {
  bind_measurement(module);
  bind_detection(module);
  bind_functions(module);
}
