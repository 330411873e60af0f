#include <pybind11/stl.h>

#include "python/numpy.hpp"
#include "python/public_names.hpp"
#include "robsim/vision/locate.hpp"

namespace py = pybind11;
using namespace robsim;
using namespace robsim::bindings;

void bind_locate(py::module_& module) {
  py::class_<Measurement>(public_in(module, "robsim"), "Measurement", R"(
The pose of a detected robot. A frame without a detection gives None instead.

Parameters
----------
pose : array (3,)
    x, y (work-area px), heading (rad).
)")
      .def(py::init([](const py::object& pose) { return Measurement{pose_from(pose, "pose")}; }),
           py::arg("pose"))
      .def_property_readonly(
          "pose", [](const Measurement& self) { return to_array(self.pose); },
          "array (3,): x, y (work-area px), heading (rad, in (-pi, pi]).")
      .def("__repr__", [](const Measurement& self) {
        return "Measurement(" + py::repr(to_array(self.pose).attr("tolist")()).cast<std::string>() +
               ")";
      });

  public_in(module, "robsim")
      .def(
          "locate",
          [](const BlobsByColor& blobs, const MarkerLayout& markers, const PlaneMap& plane_map) {
            return locate(blobs, markers, plane_map);
          },
          py::arg("blobs"), py::arg("markers"), py::arg("plane_map") = PlaneMap(), R"(
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
    None = not detected: no pair fits, or two fit equally well.
)");
}
