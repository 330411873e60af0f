#include <pybind11/stl.h>

#include <cmath>
#include <tuple>

#include "python/by_role.hpp"
#include "python/numpy.hpp"
#include "python/signature.hpp"
#include "python/values.hpp"
#include "robsim/imaging/plane_map.hpp"
#include "robsim/vision/marker_width.hpp"

namespace py = pybind11;
using namespace robsim;
using namespace robsim::bindings;

namespace {

using MarkerColors = std::optional<ByRole<std::string>>;

// In the order of the roles.
std::array<std::string, 2> colors_from(const MarkerColors& colors, MarkerRoles roles) {
  if (!colors) return default_marker_colors;
  const std::array<std::string, 2> names = in_order(*colors, roles, "colors");
  for (const std::string& name : names) name_from(py::str(name), "a name in colors");
  return names;
}

MarkerLayout with_tolerances(MarkerLayout markers, double distance_tolerance, double area_tolerance,
                             int maximum_blobs) {
  markers.distance_tolerance = distance_tolerance;
  markers.area_tolerance = area_tolerance;
  markers.maximum_blobs = maximum_blobs;
  check_marker_layout(markers);
  return markers;
}

using Place = std::pair<double, double>;
using Places = std::vector<Place>;
using Outline = std::shared_ptr<const MarkerShape>;

std::string entry(const char* name, const std::string& role) {
  return std::string(name) + "['" + role + "']";
}

Polygon polygon_of(const ByRole<ArrayLike>& polygons, const std::string& role, const char* name) {
  return polygon_from(polygons.at(role), entry(name, role).c_str());
}

MarkerLayout layout_of_polygons(const ByRole<ArrayLike>& polygons, double distance_tolerance,
                                double area_tolerance, int maximum_blobs,
                                const MarkerColors& colors) {
  const MarkerRoles roles = roles_of(polygons, "markers");
  const auto& [first, second] = names_of(roles);
  return with_tolerances(MarkerLayout::from_markers(polygon_of(polygons, first, "markers"),
                                                    polygon_of(polygons, second, "markers"),
                                                    colors_from(colors, roles), roles),
                         distance_tolerance, area_tolerance, maximum_blobs);
}

MarkerLayout layout_of_positions(const ByRole<ArrayLike>& positions,
                                 const std::optional<ByRole<std::optional<double>>>& areas,
                                 double distance_tolerance, double area_tolerance,
                                 int maximum_blobs,
                                 const std::optional<ByRole<ArrayLike>>& polygons,
                                 const MarkerColors& colors) {
  MarkerLayout markers;
  markers.roles = roles_of(positions, "positions");
  const std::array<std::string, 2> names = colors_from(colors, markers.roles);
  if (areas) check_roles(*areas, markers.roles, "areas");
  if (polygons) in_order(*polygons, markers.roles, "polygons");
  std::size_t i = 0;
  for (Marker* marker : {&markers.first, &markers.second}) {
    const std::string& role = names_of(markers.roles)[i];
    marker->color = names[i++];
    marker->position = point_from(positions.at(role), entry("positions", role).c_str());
    if (areas && areas->count(role)) marker->area = areas->at(role).value_or(marker->area);
    if (polygons) {
      marker->shape = std::make_shared<MarkerShape>(polygon_of(*polygons, role, "polygons"), role);
    }
  }
  return with_tolerances(std::move(markers), distance_tolerance, area_tolerance, maximum_blobs);
}

std::optional<py::array_t<double>> array_of(const Outline& shape) {
  if (!shape) return std::nullopt;
  const Polygon& polygon = shape->polygon();
  return to_array(&polygon[0].x, {static_cast<py::ssize_t>(polygon.size()), 2});
}

// What makes it anew, or, with outlines of many corners, what is worth knowing.
std::string repr_of_layout(const MarkerLayout& self) {
  const auto number = [](double value) {
    return std::isnan(value) ? "None" : py::repr(py::float_(value)).cast<std::string>();
  };
  const auto place = [&](const Point& point) {
    return "(" + number(point.x) + ", " + number(point.y) + ")";
  };
  const auto both = [&](const std::string& first, const std::string& second) {
    const auto& [first_role, second_role] = names_of(self.roles);
    return "{'" + first_role + "': " + first + ", '" + second_role + "': " + second + "}";
  };
  const auto quoted = [](const std::string& text) {
    return py::repr(py::str(text)).cast<std::string>();
  };
  const std::string start = both(place(self.first.position), place(self.second.position)) +
                            ", areas=" + both(number(self.first.area), number(self.second.area));
  const std::string colors =
      ", colors=" + both(quoted(self.first.color), quoted(self.second.color));
  if (self.first.shape && self.second.shape) {
    return "<MarkerLayout of polygons: " + start + colors + ">";
  }
  return "MarkerLayout.from_positions(" + start +
         ", distance_tolerance=" + number(self.distance_tolerance) +
         ", area_tolerance=" + number(self.area_tolerance) +
         ", maximum_blobs=" + std::to_string(self.maximum_blobs) + colors + ")";
}

// A marker as a value: colour, position, area, outline.
using MarkerValue = std::tuple<std::string, Place, std::optional<double>, std::optional<Places>>;

MarkerValue value_of(const Marker& marker) {
  std::optional<Places> corners;
  if (marker.shape) {
    corners = Places();
    for (const Point& corner : marker.shape->polygon()) corners->emplace_back(corner.x, corner.y);
  }
  return {marker.color, Place(marker.position.x, marker.position.y),
          std::isnan(marker.area) ? std::nullopt : std::optional(marker.area), corners};
}

Marker marker_from(const MarkerValue& value, const std::string& role) {
  const auto& [color, position, area, corners] = value;
  name_from(py::str(color), "a name in colors");
  Marker marker{color, {position.first, position.second}};
  if (area) marker.area = *area;
  if (corners) {
    const ArrayLike given(py::cast(*corners));
    marker.shape = std::make_shared<MarkerShape>(polygon_from(given, role.c_str()), role);
  }
  return marker;
}

void bind_layout_value(Class<MarkerLayout>& layout) {
  const auto make = [](const std::array<std::string, 2>& names, const MarkerValue& first,
                       const MarkerValue& second, double distance_tolerance, double area_tolerance,
                       int maximum_blobs) {
    MarkerLayout markers;
    markers.roles = roles_of(ByRole<int>{{names[0], 0}, {names[1], 1}}, "markers");
    markers.first = marker_from(first, names[0]);
    markers.second = marker_from(second, names[1]);
    return with_tolerances(std::move(markers), distance_tolerance, area_tolerance, maximum_blobs);
  };
  const Fields fields(
      make, Field("roles", [](const MarkerLayout& self) { return names_of(self.roles); }),
      Field("first", [](const MarkerLayout& self) { return value_of(self.first); }),
      Field("second", [](const MarkerLayout& self) { return value_of(self.second); }),
      Field("distance_tolerance", &MarkerLayout::distance_tolerance),
      Field("area_tolerance", &MarkerLayout::area_tolerance),
      Field("maximum_blobs", &MarkerLayout::maximum_blobs));
  define_record(layout, fields);
  layout.def("__repr__", &repr_of_layout);
}

void bind_makers_of_layouts(Class<MarkerLayout>& layout) {
  const MarkerLayout defaults;
  layout
      .def_static("from_markers", &layout_of_polygons, py::arg("markers"), py::kw_only(),
                  py::arg("distance_tolerance") = defaults.distance_tolerance,
                  py::arg("area_tolerance") = defaults.area_tolerance,
                  py::arg("maximum_blobs") = defaults.maximum_blobs, py::arg("colors") = py::none(),
                  R"(
Return the layout of these markers, with their areas.

Parameters
----------
markers : dict of str to array (N, 2)
    By role, ``"right"`` and ``"left"``, or ``"front"`` and ``"back"``: the marker's corners in the
    robot's frame: forward, right (work-area px from its centre).
distance_tolerance, area_tolerance, maximum_blobs, colors
    As for `MarkerLayout`.

Raises
------
ValueError
    If the roles are others, or contradict the positions; if a polygon is none.
)")
      .def_static("from_positions", &layout_of_positions, py::arg("positions"), py::kw_only(),
                  py::arg("areas") = py::none(),
                  py::arg("distance_tolerance") = defaults.distance_tolerance,
                  py::arg("area_tolerance") = defaults.area_tolerance,
                  py::arg("maximum_blobs") = defaults.maximum_blobs,
                  py::arg("polygons") = py::none(), py::arg("colors") = py::none(), R"(
Return the layout of markers at these positions.

Parameters
----------
positions : dict of str to array (2,)
    By role, ``"right"`` and ``"left"``, or ``"front"`` and ``"back"``: the marker's centroid in the
    robot's frame: forward, right (work-area px from its centre).
areas : dict of str to float, optional
    By role, their areas (px^2); one that is left out, or None, is not known. Default: not known.
distance_tolerance, area_tolerance, maximum_blobs, colors
    As for `MarkerLayout`.
polygons : dict of str to array (N, 2), optional
    By role, their corners, in the same frame. Default: not known; measurements are then less exact.

Raises
------
ValueError
    If the roles are others, or contradict the positions.
)");
}

void bind_markers_by_role(Class<MarkerLayout>& layout) {
  using Array = py::array_t<double>;
  layout
      .def_property_readonly(
          "roles",
          [](const MarkerLayout& self) {
            const auto& [first, second] = names_of(self.roles);
            return std::pair(first, second);
          },
          "tuple of 2 str: ``(\"right\", \"left\")`` or ``(\"front\", \"back\")``: what the "
          "markers "
          "are called\nby where they sit. All dicts of markers are in this order.")
      .def_property_readonly(
          "colors",
          [](const MarkerLayout& self) {
            return by_role<py::str>(self.roles, self.first.color, self.second.color);
          },
          "dict of str to str: by role, the names of the markers' colours.")
      .def_property_readonly(
          "positions",
          [](const MarkerLayout& self) {
            return by_role<Array>(self.roles, to_array(self.first.position),
                                  to_array(self.second.position));
          },
          "dict of str to array (2,): by role, forward and right of the robot's centre (px).")
      .def_property_readonly(
          "areas",
          [](const MarkerLayout& self) {
            return by_role<py::float_>(self.roles, self.first.area, self.second.area);
          },
          "dict of str to float: by role, px^2, NaN = unknown.")
      .def_property_readonly(
          "polygons",
          [](const MarkerLayout& self) -> std::optional<py::typing::Dict<py::str, Array>> {
            const auto first = array_of(self.first.shape), second = array_of(self.second.shape);
            if (!first || !second) return std::nullopt;
            return by_role<Array>(self.roles, *first, *second);
          },
          "dict of str to array (N, 2) or None: by role, the corners, forward and right of the "
          "centre\n(px); None = unknown, as of `from_positions`.");
}

double width_in(const MarkerLayout& self, const Frame& frame) {
  return marker_width(self, frame.plane_map, frame.image.width(), frame.image.height());
}

void bind_marker_layout(py::module_& module) {
  const MarkerLayout defaults;
  Class<MarkerLayout> layout(public_in(module, "robsim.vision"), "MarkerLayout", R"(
The two markers of a robot, their colours and positions: what turns a pair of blobs into a pose.

A marker has a role, which says where it sits on the robot, and a colour, by which it is found. The
two are ``"right"`` and ``"left"`` here: the line between them is perpendicular to the heading. Of
markers one behind the other, ``"front"`` and ``"back"``, and of other arrangements see
`from_markers` and `from_positions`.

Parameters
----------
distance : float
    Distance between the centroids of the two markers (work-area px).
offset : float
    From the midpoint of the markers forward to the robot's centre (work-area px).
distance_tolerance : float
    Maximum deviation of a pair's distance, as a fraction of the distance.
area_tolerance : float
    Maximum ratio between a blob's area and the marker's or, where the marker areas are not known,
    between the areas of a pair.
maximum_blobs : int
    How many blobs of a colour are considered, the largest first.
colors : dict of str to str, optional
    By role, the names of the colour classes: those of a colour file, such as
    ``{"right": "green", "left": "orange"}``. Default: the right or front marker is red, the other
    one blue.
)");
  layout
      .def(py::init([](double distance, double offset, double distance_tolerance,
                       double area_tolerance, int maximum_blobs, const MarkerColors& colors) {
             return with_tolerances(
                 MarkerLayout::across(distance, offset,
                                      colors_from(colors, MarkerRoles::right_left)),
                 distance_tolerance, area_tolerance, maximum_blobs);
           }),
           py::arg("distance"), py::arg("offset"), py::kw_only(),
           py::arg("distance_tolerance") = defaults.distance_tolerance,
           py::arg("area_tolerance") = defaults.area_tolerance,
           py::arg("maximum_blobs") = defaults.maximum_blobs, py::arg("colors") = py::none())
      .def("width_in", &width_in, py::arg("frame"), R"(
Return how wide the smaller marker is in the middle of a frame.

Parameters
----------
frame : Frame
    The frame; its plane map tells the scale.

Returns
-------
float
    The side of a square of its area (px of the frame); NaN if no area is known. Poses can be
    trusted from 4.5 px on.
)")
      .def_property_readonly("distance", &MarkerLayout::distance,
                             "float: distance between the markers' centroids (work-area px).")
      .def_property_readonly("offset", &MarkerLayout::offset,
                             "float: from the markers' midpoint forward to the centre (px).")
      .def_readonly("distance_tolerance", &MarkerLayout::distance_tolerance, "float: fraction.")
      .def_readonly("area_tolerance", &MarkerLayout::area_tolerance, "float: ratio.")
      .def_readonly("maximum_blobs", &MarkerLayout::maximum_blobs,
                    "int: blobs considered per colour.");
  bind_makers_of_layouts(layout);
  bind_markers_by_role(layout);
  bind_layout_value(layout);
}

void bind_roles(py::module_& module) {
  using Names = std::pair<std::string, std::string>;
  const auto names = [](MarkerRoles roles) {
    const auto& [first, second] = names_of(roles);
    return Names(first, second);
  };
  public_in(module, "robsim._core")
      .def(
          "marker_roles",
          [names] {
            return std::pair(names(MarkerRoles::right_left), names(MarkerRoles::front_back));
          },
          "The pairs of roles that two markers can have: right and left, front and back.")
      .def(
          "fitting_roles",
          [names](const ArrayLike& one, const ArrayLike& other) {
            const FittingRoles fitting =
                fitting_roles(point_from(one, "one"), point_from(other, "other"));
            const auto [first, second] = names(fitting.roles);
            return fitting.is_first_right_or_front ? Names(first, second) : Names(second, first);
          },
          py::arg("one"), py::arg("other"),
          "The roles of markers at two places, forward and right of the robot's centre.");
}

}  // namespace

void bind_markers(py::module_& module) {
  bind_roles(module);
  bind_marker_layout(module);
}
