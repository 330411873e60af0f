#include <cmath>
#include <tuple>

#include "python/by_role.hpp"
#include "python/values.hpp"
#include "robsim/imaging/plane_map.hpp"
#include "robsim/vision/marker_width.hpp"

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

MarkerLayout layout_of_polygons(const ByRole<Polygon>& polygons, double distance_tolerance,
                                double area_tolerance, int maximum_blobs,
                                const MarkerColors& colors) {
  const MarkerRoles roles = roles_of(polygons, "markers");
  const auto [first, second] = in_order(polygons, roles, "markers");
  return with_tolerances(
      MarkerLayout::from_markers(first, second, colors_from(colors, roles), roles),
      distance_tolerance, area_tolerance, maximum_blobs);
}

MarkerLayout layout_of_positions(const ByRole<Point>& positions,
                                 const std::optional<ByRole<std::optional<double>>>& areas,
                                 double distance_tolerance, double area_tolerance,
                                 int maximum_blobs, const std::optional<ByRole<Polygon>>& polygons,
                                 const MarkerColors& colors) {
  MarkerLayout markers;
  markers.roles = roles_of(positions, "positions");
  const std::array<std::string, 2> names = colors_from(colors, markers.roles);
  if (areas) checked_roles(*areas, {markers.roles}, "areas", 0);
  if (polygons) in_order(*polygons, markers.roles, "polygons");
  std::size_t i = 0;
  for (Marker* marker : {&markers.first, &markers.second}) {
    const std::string& role = names_of(markers.roles)[i];
    marker->color = names[i++];
    marker->position = positions.at(role);
    if (areas && areas->count(role)) marker->area = areas->at(role).value_or(marker->area);
    if (polygons) marker->shape = std::make_shared<MarkerShape>(polygons->at(role), role);
  }
  return with_tolerances(std::move(markers), distance_tolerance, area_tolerance, maximum_blobs);
}

py::array_t<double> array_of(const Polygon& polygon) {
  return to_array(&polygon[0].x, {static_cast<py::ssize_t>(polygon.size()), 2});
}

// The results of a function for the two markers, by role.
template <typename Annotated, typename Get>
auto of_both(const MarkerLayout& self, const Get& get) {
  return by_role<Annotated>(self.roles, get(self.first), get(self.second));
}

// The call that makes it again, or, with outlines of many corners, a summary.
py::str repr_of_layout(const MarkerLayout& self) {
  const auto positions = of_both<py::tuple>(self, [](const Marker& marker) {
    return py::make_tuple(marker.position.x, marker.position.y);
  });
  const auto areas =
      of_both<py::float_>(self, [](const Marker& marker) { return known(marker.area); });
  const auto colors = of_both<py::str>(self, [](const Marker& marker) { return marker.color; });
  if (self.first.shape && self.second.shape) {
    return py::str("<MarkerLayout of polygons: {}, areas={}, colors={}>")
        .format(positions, areas, colors);
  }
  return py::str(
             "MarkerLayout.from_positions({}, areas={}, distance_tolerance={}, "
             "area_tolerance={}, maximum_blobs={}, colors={})")
      .format(positions, areas, self.distance_tolerance, self.area_tolerance, self.maximum_blobs,
              colors);
}

using RoleNames = std::pair<std::string, std::string>;

RoleNames pair_of(MarkerRoles roles) { return {names_of(roles)[0], names_of(roles)[1]}; }

void define_layout(Class<MarkerLayout>& layout) {
  using Array = py::array_t<double>;
  const auto positions = [](const MarkerLayout& self) {
    return of_both<Array>(self, [](const Marker& marker) { return marker.position; });
  };
  const auto areas = [](const MarkerLayout& self) {
    return of_both<py::float_>(self, [](const Marker& marker) { return marker.area; });
  };
  const auto polygons =
      [](const MarkerLayout& self) -> std::optional<py::typing::Dict<py::str, Array>> {
    if (!self.first.shape || !self.second.shape) return std::nullopt;
    return of_both<Array>(self, [](const Marker& of) { return array_of(of.shape->polygon()); });
  };
  const auto colors = [](const MarkerLayout& self) {
    return of_both<py::str>(self, [](const Marker& marker) { return marker.color; });
  };
  define_record(
      layout,
      Fields(
          &layout_of_positions,
          Field("positions", positions,
                "dict of str to array (2,): by role, forward and right of the robot's centre "
                "(px)."),
          Field("areas", areas, "dict of str to float: by role, px^2, NaN = unknown."),
          Field("distance_tolerance", &MarkerLayout::distance_tolerance, "float: fraction."),
          Field("area_tolerance", &MarkerLayout::area_tolerance, "float: ratio."),
          Field("maximum_blobs", &MarkerLayout::maximum_blobs, "int: blobs considered per colour."),
          Field("polygons", polygons,
                "dict of str to array (N, 2) or None: by role, the corners, forward and right of "
                "the centre\n(px); None = unknown, as from `from_positions`."),
          Field("colors", colors,
                "dict of str to str: by role, the names of the markers' colours.")));
  layout
      .def_property_readonly(
          "roles", [](const MarkerLayout& self) { return pair_of(self.roles); },
          "tuple of 2 str: ``(\"right\", \"left\")`` or ``(\"front\", \"back\")``: the markers' "
          "roles, by their places. All dicts of markers have this order.")
      .def("__repr__", &repr_of_layout);
}

void bind_makers_of_layouts(Class<MarkerLayout>& layout) {
  const MarkerLayout defaults;
  layout
      .def_static("from_markers", &layout_of_polygons, "markers"_a, py::kw_only(),
                  "distance_tolerance"_a = defaults.distance_tolerance,
                  "area_tolerance"_a = defaults.area_tolerance,
                  "maximum_blobs"_a = defaults.maximum_blobs, "colors"_a = py::none(),
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
    If the roles are unknown or contradict the positions, or if a polygon is invalid.
)")
      .def_static("from_positions", &layout_of_positions, "positions"_a, py::kw_only(),
                  "areas"_a = py::none(), "distance_tolerance"_a = defaults.distance_tolerance,
                  "area_tolerance"_a = defaults.area_tolerance,
                  "maximum_blobs"_a = defaults.maximum_blobs, "polygons"_a = py::none(),
                  "colors"_a = py::none(), R"(
Return the layout of markers at these positions.

Parameters
----------
positions : dict of str to array (2,)
    By role, ``"right"`` and ``"left"``, or ``"front"`` and ``"back"``: the marker's centroid in the
    robot's frame: forward, right (work-area px from its centre).
areas : dict of str to float, optional
    By role, their areas (px^2); an omitted area, or None, is not known. Default: not known.
distance_tolerance, area_tolerance, maximum_blobs, colors
    As for `MarkerLayout`.
polygons : dict of str to array (N, 2), optional
    By role, their corners, in the same frame. Default: not known, which makes measurements less
    exact.

Raises
------
ValueError
    If the roles are unknown, or contradict the positions.
)");
}

double width_in(const MarkerLayout& self, const Frame& frame) {
  return marker_width(self, frame.plane_map, frame.image.width(), frame.image.height());
}

void bind_marker_layout(py::module_& module) {
  const MarkerLayout defaults;
  Class<MarkerLayout> layout(public_in(module, "robsim.vision"), "MarkerLayout", R"(
The two markers of a robot, their colours and positions, which turn a pair of blobs into a pose.

A marker has a role, which gives its position on the robot, and a colour, by which vision finds it.
The roles here are ``"right"`` and ``"left"``: the line between the two markers is perpendicular to
the heading. See `from_markers` and `from_positions` for markers one behind the other (``"front"``
and ``"back"``) and for other arrangements.

Parameters
----------
distance : float
    Distance between the centroids of the two markers (work-area px).
offset : float
    Distance from the midpoint of the markers forward to the robot's centre (work-area px).
distance_tolerance : float
    Maximum deviation of a pair's distance, as a fraction of the distance.
area_tolerance : float
    Maximum ratio between a blob's area and the marker's or, where the marker areas are not known,
    between the areas of a pair.
maximum_blobs : int
    Number of considered blobs of a colour, the largest first.
colors : dict of str to str, optional
    By role, the colour classes' names, such as ``{"right": "green", "left": "orange"}``, as in a
    colour file. Default: the right or front marker is red, the other one blue.

Examples
--------
>>> markers = robsim.vision.MarkerLayout(distance=43, offset=12)
>>> markers.colors
{'right': 'red', 'left': 'blue'}
)");
  layout
      .def(py::init([](double distance, double offset, double distance_tolerance,
                       double area_tolerance, int maximum_blobs, const MarkerColors& colors) {
             return with_tolerances(
                 MarkerLayout::across(distance, offset,
                                      colors_from(colors, MarkerRoles::right_left)),
                 distance_tolerance, area_tolerance, maximum_blobs);
           }),
           "distance"_a, "offset"_a, py::kw_only(),
           "distance_tolerance"_a = defaults.distance_tolerance,
           "area_tolerance"_a = defaults.area_tolerance, "maximum_blobs"_a = defaults.maximum_blobs,
           "colors"_a = py::none())
      .def("width_in", &width_in, "frame"_a, R"(
Return the width of the smaller marker in the middle of a frame.

Parameters
----------
frame : Frame
    The frame; its plane map gives the scale.

Returns
-------
float
    The side of a square of its area (px of the frame); NaN if no area is known. Poses are reliable
    from a width of 4.5 px on.
)")
      .def_property_readonly("distance", &MarkerLayout::distance,
                             "float: distance between the markers' centroids (work-area px).")
      .def_property_readonly(
          "offset", &MarkerLayout::offset,
          "float: distance from the markers' midpoint forward to the centre (px).");
  bind_makers_of_layouts(layout);
  define_layout(layout);
}

void bind_roles(py::module_& module) {
  public_in(module, "robsim._core")
      .def(
          "marker_roles",
          [] {
            return std::pair(pair_of(MarkerRoles::right_left), pair_of(MarkerRoles::front_back));
          },
          "The pairs of roles that two markers can have: right and left, front and back.")
      .def(
          "fitting_roles",
          [](const Point& one, const Point& other) {
            const FittingRoles fitting = fitting_roles(one, other);
            const auto [first, second] = pair_of(fitting.roles);
            return fitting.is_first_right_or_front ? RoleNames(first, second)
                                                   : RoleNames(second, first);
          },
          "one"_a, "other"_a,
          "The roles of markers at two places, forward and right of the robot's centre.");
}

}  // namespace

void bind_markers(py::module_& module) {
  bind_roles(module);
  bind_marker_layout(module);
}
