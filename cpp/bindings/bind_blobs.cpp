#include <pybind11/stl.h>

#include <cmath>
#include <tuple>

#include "python/interpreter.hpp"
#include "python/names.hpp"
#include "python/numpy.hpp"
#include "python/public_names.hpp"
#include "python/values.hpp"
#include "robsim/imaging/frame.hpp"
#include "robsim/vision/light/relative_classifier.hpp"
#include "robsim/vision/marker_blobs.hpp"

namespace py = pybind11;
using namespace robsim;
using namespace robsim::bindings;

namespace {

std::string repr(const Blob& blob) {
  return py::str("<Blob {}: area {} px, centroid ({:.2f}, {:.2f})>")
      .format(blob.color, blob.area, blob.centroid.x, blob.centroid.y)
      .cast<std::string>();
}

using Box = std::tuple<int, int, int, int>;

Box box_of(const Blob& blob) {
  return {blob.box.left, blob.box.top, blob.box.right - 1, blob.box.bottom - 1};
}

Blob make_blob(const std::string& color, std::int64_t area, const ArrayLike& centroid,
               const Region& bounding_box, bool at_border) {
  if (area < 1) throw py::value_error("area must be at least 1 px");
  const PixelBox box = region_from(bounding_box, "bounding_box");
  if (box.left >= box.right || box.top >= box.bottom) {
    throw py::value_error("bounding_box must have u_min <= u_max and v_min <= v_max, got " +
                          describe(bounding_box));
  }
  return {color, area, point_from(centroid, "centroid"), box, at_border};
}

void define_blob_value(Class<Blob>& cls) {
  const auto make = [](const std::string& color, std::int64_t area, std::pair<double, double> at,
                       const Box& box, bool at_border) {
    return make_blob(color, area, ArrayLike(py::cast(at)), Region(py::cast(box)), at_border);
  };
  const auto centroid = [](const Blob& b) { return std::pair(b.centroid.x, b.centroid.y); };
  const Fields fields(make, Field("color", &Blob::color), Field("area", &Blob::area),
                      Field("centroid", centroid), Field("bounding_box", &box_of),
                      Field("at_border", &Blob::at_border));
  define_equality(cls, fields);
  define_hash(cls, fields);
  define_pickle(cls, fields);
}

PlaneMap plane_map_of(const ImageLike& image) {
  return py::isinstance<Frame>(image) ? image.cast<const Frame&>().plane_map : PlaneMap();
}

BlobsByColor find(const ImageLike& image, const std::vector<ColorClass>& colors,
                  const std::optional<MarkerLayout>& markers,
                  std::optional<std::int64_t> minimum_area, std::optional<int> maximum_count,
                  std::optional<int> smoothing, const std::optional<Region>& region) {
  const ImageView view = view_from(image, "image");
  BlobOptions options;
  if (markers) options = marker_blobs(*markers, plane_map_of(image), view);
  if (minimum_area) options.minimum_area = *minimum_area;
  if (maximum_count) options.maximum_count = *maximum_count;
  if (smoothing) options.smoothing = *smoothing;
  BlobFinder finder(colors, options);
  const PixelBox part =
      region ? region_from(*region, "region") : PixelBox{0, 0, view.width, view.height};
  const WithoutInterpreter native;
  return finder.find(view, part);
}

using Masks = std::map<std::string, py::array_t<bool>>;

template <typename Classifier>
Masks masks_from(Classifier& classifier, const ImageView& view,
                 const std::vector<ColorClass>& colors) {
  Masks masks;
  std::vector<bool*> next;
  for (const ColorClass& color : colors) {
    py::array_t<bool>& mask =
        masks.try_emplace(color.name, Shape{view.height, view.width}).first->second;
    next.push_back(mask.mutable_data());
  }
  const WithoutInterpreter native;
  for (int v = 0; v < view.height; ++v) {
    const std::vector<pixels::BitRow>& bits = classifier.next_row();
    for (std::size_t i = 0; i < colors.size(); ++i) {
      for (int u = 0; u < view.width; ++u) *next[i]++ = pixels::is_set(bits[i], u);
    }
  }
  return masks;
}

Masks masks_of(const ImageLike& image, const std::vector<ColorClass>& colors,
               const std::optional<MarkerLayout>& markers, std::optional<int> smoothing) {
  const ImageView view = view_from(image, "image");
  BlobOptions options;
  if (markers) options = marker_blobs(*markers, plane_map_of(image), view);
  pixels::RowClassifier classifier(colors, smoothing.value_or(options.smoothing));
  classifier.begin(view);
  return masks_from(classifier, view, colors);
}

// The masks of the second chance, for tests.
Masks relative_masks_of(const ImageLike& image, const std::vector<ColorClass>& colors,
                        int smoothing, const light::Gains& gains, float least_chroma) {
  const ImageView view = view_from(image, "image");
  if (smoothing < 1 || smoothing > 15 || smoothing % 2 == 0) {
    throw py::value_error("smoothing must be 1, 3, ... 15 px, got " + std::to_string(smoothing));
  }
  std::vector<std::optional<light::RelativeClass>> classes;
  for (const ColorClass& color : colors) {
    classes.push_back(light::relative_to_brightness(color, least_chroma));
  }
  light::RelativeClassifier classifier(view, std::move(classes), smoothing, gains);
  return masks_from(classifier, view, colors);
}

using MarkerColors = std::array<std::string, 2>;

MarkerLayout with_options(MarkerLayout markers, double distance_tolerance, double area_tolerance,
                          int maximum_blobs, const MarkerColors& colors) {
  for (const std::string& color : colors) name_from(py::str(color), "a name in colors");
  markers.first.color = colors[0];
  markers.second.color = colors[1];
  markers.distance_tolerance = distance_tolerance;
  markers.area_tolerance = area_tolerance;
  markers.maximum_blobs = maximum_blobs;
  check_marker_layout(markers);
  return markers;
}

using Place = std::pair<double, double>;

using Places = std::vector<Place>;
using OutlinePointer = std::shared_ptr<const MarkerShape>;

MarkerLayout layout_from(Place red, Place blue, std::optional<double> red_area,
                         std::optional<double> blue_area, double distance_tolerance,
                         double area_tolerance, int maximum_blobs, const MarkerColors& colors) {
  MarkerLayout markers;
  markers.first.position = {red.first, red.second};
  markers.second.position = {blue.first, blue.second};
  if (red_area) markers.first.area = *red_area;
  if (blue_area) markers.second.area = *blue_area;
  return with_options(markers, distance_tolerance, area_tolerance, maximum_blobs, colors);
}

std::pair<std::string, std::string> colors_of(const MarkerLayout& self) {
  return {self.first.color, self.second.color};
}

std::optional<Places> places_of(const OutlinePointer& shape) {
  if (!shape) return std::nullopt;
  Places places;
  for (const Point& corner : shape->polygon()) places.emplace_back(corner.x, corner.y);
  return places;
}

OutlinePointer outline_from(const std::optional<ArrayLike>& corners, const char* name) {
  return corners ? std::make_shared<MarkerShape>(polygon_from(*corners, name), name) : nullptr;
}

// What makes it anew, or, with outlines of many corners, what is worth knowing.
std::string repr_of_layout(const MarkerLayout& self) {
  const auto number = [](double value) {
    return std::isnan(value) ? "None" : py::repr(py::float_(value)).cast<std::string>();
  };
  const auto place = [&](const Point& point) {
    return "(" + number(point.x) + ", " + number(point.y) + ")";
  };
  const std::string start =
      "red=" + place(self.first.position) + ", blue=" + place(self.second.position) +
      ", red_area=" + number(self.first.area) + ", blue_area=" + number(self.second.area);
  const std::string colors = py::repr(py::cast(colors_of(self))).cast<std::string>();
  if (self.first.shape && self.second.shape) {
    return "<MarkerLayout of polygons: " + start + ", colors=" + colors + ">";
  }
  return "MarkerLayout.from_positions(" + start +
         ", distance_tolerance=" + number(self.distance_tolerance) +
         ", area_tolerance=" + number(self.area_tolerance) +
         ", maximum_blobs=" + std::to_string(self.maximum_blobs) + ", colors=" + colors + ")";
}

std::optional<py::array_t<double>> array_of(const OutlinePointer& shape) {
  if (!shape) return std::nullopt;
  const Polygon& polygon = shape->polygon();
  return to_array(&polygon[0].x, {static_cast<py::ssize_t>(polygon.size()), 2});
}

void bind_layout_value(Class<MarkerLayout>& layout) {
  const MarkerLayout defaults;
  layout.def_static(
      "from_positions",
      [](const ArrayLike& red, const ArrayLike& blue, std::optional<double> red_area,
         std::optional<double> blue_area, double distance_tolerance, double area_tolerance,
         int maximum_blobs, const std::optional<ArrayLike>& red_polygon,
         const std::optional<ArrayLike>& blue_polygon, const MarkerColors& colors) {
        const Point r = point_from(red, "red");
        const Point b = point_from(blue, "blue");
        MarkerLayout markers =
            layout_from({r.x, r.y}, {b.x, b.y}, red_area, blue_area, distance_tolerance,
                        area_tolerance, maximum_blobs, colors);
        markers.first.shape = outline_from(red_polygon, "red_polygon");
        markers.second.shape = outline_from(blue_polygon, "blue_polygon");
        check_marker_layout(markers);
        return markers;
      },
      py::arg("red"), py::arg("blue"), py::kw_only(), py::arg("red_area") = py::none(),
      py::arg("blue_area") = py::none(),
      py::arg("distance_tolerance") = defaults.distance_tolerance,
      py::arg("area_tolerance") = defaults.area_tolerance,
      py::arg("maximum_blobs") = defaults.maximum_blobs, py::arg("red_polygon") = py::none(),
      py::arg("blue_polygon") = py::none(), py::arg("colors") = default_marker_colors, R"(
Return the layout of markers at these positions.

Parameters
----------
red, blue : array (2,)
    Centroids of the first and the second marker in the robot's frame: forward, right (work-area px from its centre).
red_area, blue_area : float, optional
    Their areas (px^2). Default: not known.
distance_tolerance, area_tolerance, maximum_blobs
    As for `MarkerLayout`.
red_polygon, blue_polygon : array (N, 2), optional
    Their corners, in the same frame. Default: not known; measurements are then less exact.
colors : sequence of 2 str
    As for `MarkerLayout`.
)");
  using Member = Marker MarkerLayout::*;
  const auto place = [](Member which) {
    return [which](const MarkerLayout& self) {
      const Point& position = (self.*which).position;
      return Place(position.x, position.y);
    };
  };
  const auto area = [](Member which) {
    return [which](const MarkerLayout& self) {
      const double value = (self.*which).area;
      return std::isnan(value) ? std::nullopt : std::optional(value);
    };
  };
  const auto outline = [](Member which) {
    return [which](const MarkerLayout& self) { return places_of((self.*which).shape); };
  };
  const auto make =
      [](Place red, Place blue, std::optional<double> red_area, std::optional<double> blue_area,
         double distance_tolerance, double area_tolerance, int maximum_blobs,
         const std::optional<Places>& red_outline, const std::optional<Places>& blue_outline,
         const std::pair<std::string, std::string>& colors) {
        MarkerLayout markers =
            layout_from(red, blue, red_area, blue_area, distance_tolerance, area_tolerance,
                        maximum_blobs, {colors.first, colors.second});
        const auto of = [](const std::optional<Places>& places, const char* name) {
          return outline_from(places ? std::optional(ArrayLike(py::cast(*places))) : std::nullopt,
                              name);
        };
        markers.first.shape = of(red_outline, "red_polygon");
        markers.second.shape = of(blue_outline, "blue_polygon");
        check_marker_layout(markers);
        return markers;
      };
  const Fields fields(
      make, Field("red", place(&MarkerLayout::first)), Field("blue", place(&MarkerLayout::second)),
      Field("red_area", area(&MarkerLayout::first)),
      Field("blue_area", area(&MarkerLayout::second)),
      Field("distance_tolerance", &MarkerLayout::distance_tolerance),
      Field("area_tolerance", &MarkerLayout::area_tolerance),
      Field("maximum_blobs", &MarkerLayout::maximum_blobs),
      Field("red_polygon", outline(&MarkerLayout::first)),
      Field("blue_polygon", outline(&MarkerLayout::second)), Field("colors", &colors_of));
  define_equality(layout, fields);
  define_hash(layout, fields);
  define_pickle(layout, fields);
  layout.def("__repr__", &repr_of_layout);
}

double width_in(const MarkerLayout& self, const Frame& frame) {
  return marker_width(self, frame.plane_map, frame.image.width(), frame.image.height());
}

void bind_marker_layout(py::module_& module) {
  const MarkerLayout defaults;
  Class<MarkerLayout> layout(public_in(module, "robsim.vision"), "MarkerLayout", R"(
The two markers of a robot, their colours and positions: what turns a pair of blobs into a pose.

The first marker is called ``red`` and the second one ``blue`` here, as in the lab robot, whatever
the `colors` are by which they are found. The line from the second to the first is perpendicular to
the heading, the first on the robot's right. For other arrangements see `from_markers` and
`from_positions`.

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
colors : sequence of 2 str
    Names of the colour classes of the first and of the second marker: those of a colour file, such
    as ``("green", "orange")``.
)");
  layout
      .def(py::init([](double distance, double offset, double distance_tolerance,
                       double area_tolerance, int maximum_blobs, const MarkerColors& colors) {
             return with_options(MarkerLayout::across(distance, offset), distance_tolerance,
                                 area_tolerance, maximum_blobs, colors);
           }),
           py::arg("distance"), py::arg("offset"), py::kw_only(),
           py::arg("distance_tolerance") = defaults.distance_tolerance,
           py::arg("area_tolerance") = defaults.area_tolerance,
           py::arg("maximum_blobs") = defaults.maximum_blobs,
           py::arg("colors") = default_marker_colors)
      .def_static(
          "from_markers",
          [](const ArrayLike& red, const ArrayLike& blue, double distance_tolerance,
             double area_tolerance, int maximum_blobs, const MarkerColors& colors) {
            return with_options(
                MarkerLayout::from_markers(polygon_from(red, "red"), polygon_from(blue, "blue")),
                distance_tolerance, area_tolerance, maximum_blobs, colors);
          },
          py::arg("red"), py::arg("blue"), py::kw_only(),
          py::arg("distance_tolerance") = defaults.distance_tolerance,
          py::arg("area_tolerance") = defaults.area_tolerance,
          py::arg("maximum_blobs") = defaults.maximum_blobs,
          py::arg("colors") = default_marker_colors, R"(
Return the layout of these markers, with their areas.

Parameters
----------
red, blue : array (N, 2)
    Corners of the first and the second marker in the robot's frame: forward, right (work-area px from its centre).
distance_tolerance, area_tolerance, maximum_blobs, colors
    As for `MarkerLayout`.
)")
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
      .def_property_readonly(
          "red", [](const MarkerLayout& self) { return to_array(self.first.position); },
          "array (2,): position of the first marker, forward and right of the centre (px).")
      .def_property_readonly(
          "blue", [](const MarkerLayout& self) { return to_array(self.second.position); },
          "array (2,): position of the second marker, forward and right of the centre (px).")
      .def_property_readonly(
          "red_polygon", [](const MarkerLayout& self) { return array_of(self.first.shape); },
          "array (N, 2) or None: corners of the first marker, forward and right of the centre "
          "(px);\n"
          "None = unknown, as of `from_positions`.")
      .def_property_readonly(
          "blue_polygon", [](const MarkerLayout& self) { return array_of(self.second.shape); },
          "array (N, 2) or None: corners of the second marker.")
      .def_property_readonly(
          "red_area", [](const MarkerLayout& self) { return self.first.area; },
          "float: of the first marker, px^2, NaN = unknown.")
      .def_property_readonly(
          "blue_area", [](const MarkerLayout& self) { return self.second.area; },
          "float: of the second marker, px^2, NaN = unknown.")
      .def_property_readonly("colors", &colors_of, "tuple of 2 str: names of the markers' colours.")
      .def_readonly("distance_tolerance", &MarkerLayout::distance_tolerance, "float: fraction.")
      .def_readonly("area_tolerance", &MarkerLayout::area_tolerance, "float: ratio.")
      .def_readonly("maximum_blobs", &MarkerLayout::maximum_blobs,
                    "int: blobs considered per colour.");
  bind_layout_value(layout);
}

void bind_find_blobs(py::module_& module) {
  Class<Blob> blob(public_in(module, "robsim.vision"), "Blob", R"(
A connected component (8 neighbours) of pixels of one colour class, in pixels of its frame.

Parameters
----------
color : str
    Name of the colour class.
area : int
    Number of pixels.
centroid : array (2,)
    Mean (u, v) of its pixels.
bounding_box : tuple of int
    (u_min, v_min, u_max, v_max), all included.
at_border : bool
    Whether it touches the edge of the frame and may continue beyond it.
)");
  blob.def(py::init(&make_blob), py::arg("color"), py::kw_only(), py::arg("area"),
           py::arg("centroid"), py::arg("bounding_box"), py::arg("at_border").noconvert() = false)
      .def_readonly("color", &Blob::color, "str: name of the colour class.")
      .def_readonly("area", &Blob::area, "int: number of pixels.")
      .def_property_readonly(
          "centroid", [](const Blob& self) { return to_array(self.centroid); },
          "array (2,): mean (u, v) of its pixels.")
      .def_property_readonly("bounding_box", &box_of,
                             "tuple of int: (u_min, v_min, u_max, v_max), all included.")
      .def_readonly("at_border", &Blob::at_border,
                    "bool: it touches the edge of the frame and may continue beyond it.")
      .def("__repr__", py::overload_cast<const Blob&>(&repr));
  define_blob_value(blob);

  public_in(module, "robsim")
      .def("find_blobs", &find, py::arg("image"), py::arg("colors"), py::kw_only(),
           py::arg("markers") = py::none(), py::arg("minimum_area") = py::none(),
           py::arg("maximum_count") = py::none(), py::arg("smoothing") = py::none(),
           py::arg("region") = py::none(), R"(
Find the blobs of every colour class in one pass over an image.

Parameters
----------
image : Frame or array (H, W, 3) of uint8
    RGB; rows of any stride.
colors : list of ColorClass
    The colours to find; a pixel may belong to several.
markers : MarkerLayout, optional
    The markers to find: the other options default to values that find them, in noise, too. Its
    lengths are in px of an array, or converted by the plane map of a Frame.
minimum_area : int, optional
    Smaller blobs are dropped (px). Default: 12, or 1/8 of the area of the smaller marker.
maximum_count : int, optional
    How many blobs of a colour are returned, the largest first. Default: 64, or the
    `maximum_blobs` of the markers.
smoothing : int, optional
    Width of the window whose mean classifies a pixel, against noise: 3, 5, ... 15 px, between 1/4
    and 3/4 of a marker's width; 1 = off. Default: 1, or 0.28 of the width of the smaller marker, 3
    to 7; below a marker of 7 px, 3 in images with noise and 1 in others.
region : tuple of int, optional
    (left, top, right, bottom) in px, all four included, as in a blob's bounding box: only these
    pixels are searched, as if the image ended there. Positions are those in the whole image.

Returns
-------
dict of str to list of Blob
    Per colour the blobs, the largest first.

Raises
------
TypeError, ValueError
    For an image of the wrong type or shape, duplicate colour names, and options out of range.
)");

  public_in(module, "robsim._core")
      .def("relative_masks", &relative_masks_of, py::arg("image"), py::arg("colors"),
           py::arg("smoothing"), py::arg("gains"), py::arg("least_chroma"),
           "Which pixels belong to which colour relative to brightness: the masks of the second "
           "chance.");

  public_in(module, "robsim.vision")
      .def("classify", &masks_of, py::arg("image"), py::arg("colors"), py::kw_only(),
           py::arg("markers") = py::none(), py::arg("smoothing") = py::none(), R"(
Return which pixels belong to which colour class: the masks that `find_blobs` works on.

Parameters
----------
image : Frame or array (H, W, 3) of uint8
    RGB; rows of any stride.
colors : list of ColorClass
    The colours; a pixel may belong to several.
markers : MarkerLayout, optional
    The markers to find, from which `smoothing` follows as in `find_blobs`.
smoothing : int, optional
    Width of the window whose mean classifies a pixel, as in `find_blobs`; 1 = off. Default: 1, or
    as `find_blobs` has it for the markers.

Returns
-------
dict of str to array (H, W) of bool
    Per colour, True for its pixels.

Raises
------
TypeError, ValueError
    For an image of the wrong type or shape, duplicate colour names, and options out of range.
)");
}

}  // namespace

void bind_blobs(py::module_& module) {
  bind_marker_layout(module);
  bind_find_blobs(module);
}
