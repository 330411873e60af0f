#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "numpy.hpp"
#include "robsim/imaging/frame.hpp"
#include "robsim/vision/color/color_training.hpp"
#include "robsim/vision/marker_blobs.hpp"

namespace py = pybind11;
using namespace robsim;
using namespace robsim::bindings;

namespace {

using Range = std::pair<int, int>;

constexpr double most_pixels = 1e15;  // of histograms: their sums are exact

ColorClass color_from(const py::str& name, Range y, Range u, Range v) {
  const ColorClass color{name, {y.first, u.first, v.first}, {y.second, u.second, v.second}};
  check_color_class(color);
  return color;
}

Range range_of(const ColorClass& color, std::size_t channel) {
  return {color.lower[channel], color.upper[channel]};
}

std::string repr(const ColorClass& color) {
  const auto text = [&](std::size_t i) {
    return py::repr(py::cast(range_of(color, i))).cast<std::string>();
  };
  return "ColorClass('" + color.name + "', y=" + text(0) + ", u=" + text(1) + ", v=" + text(2) +
         ")";
}

std::string repr(const Blob& blob) {
  return "<Blob " + blob.color + ": area " + std::to_string(blob.area) + " px, centroid (" +
         std::to_string(blob.centroid.x) + ", " + std::to_string(blob.centroid.y) + ")>";
}

ImageView view_of(const py::object& image) {
  if (py::isinstance<Frame>(image)) return image.cast<const Frame&>().image.view();
  return image_view(image, "image");
}

PlaneMap plane_map_of(const py::object& image) {
  return py::isinstance<Frame>(image) ? image.cast<const Frame&>().plane_map : PlaneMap();
}

PixelBox region_from(const py::object& region) {
  try {
    const auto [left, top, right, bottom] = region.cast<std::tuple<int, int, int, int>>();
    constexpr int most = std::numeric_limits<int>::max() - 1;
    return {left, top, std::min(right, most) + 1, std::min(bottom, most) + 1};
  } catch (const py::cast_error&) {
    throw py::type_error("region must be (left, top, right, bottom), four ints, got " +
                         describe(region));
  }
}

BlobsByColor find(const py::object& image, const std::vector<ColorClass>& colors,
                  const std::optional<MarkerLayout>& markers,
                  std::optional<std::int64_t> minimum_area, std::optional<int> maximum_count,
                  std::optional<int> smoothing, const py::object& region) {
  const ImageView view = view_of(image);
  BlobOptions options;
  if (markers) options = marker_blobs(*markers, plane_map_of(image), view.width, view.height);
  if (minimum_area) options.minimum_area = *minimum_area;
  if (maximum_count) options.maximum_count = *maximum_count;
  if (smoothing) options.smoothing = *smoothing;
  BlobFinder finder(colors, options);
  const PixelBox part =
      region.is_none() ? PixelBox{0, 0, view.width, view.height} : region_from(region);
  const py::gil_scoped_release native;
  return finder.find(view, part);
}

std::map<std::string, py::array_t<bool>> masks_of(const py::object& image,
                                                  const std::vector<ColorClass>& colors,
                                                  int smoothing) {
  const ImageView view = view_of(image);
  pixels::RowClassifier classifier(colors, smoothing);
  std::map<std::string, py::array_t<bool>> masks;
  std::vector<bool*> next;
  for (const ColorClass& color : colors) {
    py::array_t<bool>& mask =
        masks.try_emplace(color.name, Shape{view.height, view.width}).first->second;
    next.push_back(mask.mutable_data());
  }
  const py::gil_scoped_release native;
  classifier.begin(view);
  for (int v = 0; v < view.height; ++v) {
    const std::vector<pixels::BitRow>& bits = classifier.next_row();
    for (std::size_t i = 0; i < colors.size(); ++i) {
      for (int u = 0; u < view.width; ++u) *next[i]++ = pixels::is_set(bits[i], u);
    }
  }
  return masks;
}

py::array_t<std::uint8_t> yuv_of(const py::object& image) {
  const ImageView view = image_view(image, "image");
  py::array_t<std::uint8_t> result({view.height, view.width, 3});
  std::uint8_t* to = result.mutable_data();
  for (int v = 0; v < view.height; ++v) {
    for (int u = 0; u < view.width; ++u, to += 3) {
      const Yuv yuv = rgb_to_yuv(view.row(v) + std::ptrdiff_t{3} * u);
      to[0] = static_cast<std::uint8_t>(yuv.y);
      to[1] = static_cast<std::uint8_t>(yuv.u);
      to[2] = static_cast<std::uint8_t>(yuv.v);
    }
  }
  return result;
}

ColorHistograms histograms_from(const py::object& histograms) {
  const std::string expected = "counts of shape (3, 256), as from color_histograms";
  const Doubles counts = doubles_from(histograms, "histograms", Shape{3, 256}, expected);
  ColorHistograms result{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t value = 0; value < 256; ++value) {
      const double count = counts.at(i, value);
      if (count < 0 || count > most_pixels || count != std::floor(count)) {
        throw py::value_error("histograms must be " + expected + ", got " + std::to_string(count));
      }
      result[i][value] = static_cast<std::int64_t>(count);
    }
  }
  return result;
}

py::array_t<std::int64_t> histograms_of(const py::object& image, const py::object& region) {
  const ColorHistograms histograms = color_histograms(view_of(image), region_from(region));
  py::array_t<std::int64_t> result({3, 256});
  for (std::size_t i = 0; i < 3; ++i) {
    std::copy(histograms[i].begin(), histograms[i].end(), result.mutable_data(i));
  }
  return result;
}

MarkerLayout with_options(MarkerLayout markers, double distance_tolerance, double area_tolerance,
                          int maximum_blobs) {
  markers.distance_tolerance = distance_tolerance;
  markers.area_tolerance = area_tolerance;
  markers.maximum_blobs = maximum_blobs;
  check_marker_layout(markers);
  return markers;
}

void bind_locator(py::module_& module) {
  const MarkerLayout defaults;
  py::class_<MarkerLayout>(module, "MarkerLayout", R"(
Where a robot carries its red and its blue marker: what turns a pair of blobs into a pose.

The line from blue to red lies across the heading, red on the robot's right. Markers in other
places: see `from_markers`.

Parameters
----------
distance : float
    Between the centroids of the two markers (work-area px).
offset : float
    From the midpoint of the markers forward to the robot's centre (work-area px).
distance_tolerance : float
    Greatest deviation of a pair's distance, as a share of the distance.
area_tolerance : float
    Greatest factor between a blob's area and the marker's; where the areas are not known, between
    the two blobs of a pair.
maximum_blobs : int
    So many of the largest blobs of a colour are looked at.
)")
      .def(py::init([](double distance, double offset, double distance_tolerance,
                       double area_tolerance, int maximum_blobs) {
             return with_options(MarkerLayout::across(distance, offset), distance_tolerance,
                                 area_tolerance, maximum_blobs);
           }),
           py::arg("distance"), py::arg("offset"), py::kw_only(),
           py::arg("distance_tolerance") = defaults.distance_tolerance,
           py::arg("area_tolerance") = defaults.area_tolerance,
           py::arg("maximum_blobs") = defaults.maximum_blobs)
      .def_static(
          "from_markers",
          [](const py::object& red, const py::object& blue, double distance_tolerance,
             double area_tolerance, int maximum_blobs) {
            return with_options(
                MarkerLayout::from_markers(polygon_from(red, "red"), polygon_from(blue, "blue")),
                distance_tolerance, area_tolerance, maximum_blobs);
          },
          py::arg("red"), py::arg("blue"), py::kw_only(),
          py::arg("distance_tolerance") = defaults.distance_tolerance,
          py::arg("area_tolerance") = defaults.area_tolerance,
          py::arg("maximum_blobs") = defaults.maximum_blobs, R"(
Return the marker layout of a robot with these markers; it knows their areas, too.

Parameters
----------
red, blue : array (N, 2)
    Corners of the markers in the robot's frame: forward, right (work-area px from its centre).
distance_tolerance, area_tolerance, maximum_blobs
    As for `MarkerLayout`.
)")
      .def_property_readonly("distance", &MarkerLayout::distance,
                             "float: between the markers' centroids (work-area px).")
      .def_property_readonly("offset", &MarkerLayout::offset,
                             "float: from the markers' midpoint forward to the centre (px).")
      .def_property_readonly(
          "red", [](const MarkerLayout& self) { return to_array(self.red); },
          "array (2,): the red marker's place, forward and right of the centre (px).")
      .def_property_readonly(
          "blue", [](const MarkerLayout& self) { return to_array(self.blue); },
          "array (2,): the blue marker's place, forward and right of the centre (px).")
      .def_readonly("red_area", &MarkerLayout::red_area, "float: px^2, NaN = not known.")
      .def_readonly("blue_area", &MarkerLayout::blue_area, "float: px^2, NaN = not known.")
      .def_readonly("distance_tolerance", &MarkerLayout::distance_tolerance, "float: share.")
      .def_readonly("area_tolerance", &MarkerLayout::area_tolerance, "float: factor.")
      .def_readonly("maximum_blobs", &MarkerLayout::maximum_blobs,
                    "int: of the largest of a colour.")
      .def("__repr__", [](const MarkerLayout& self) {
        return "<MarkerLayout: markers " + std::to_string(self.distance()) + " px apart, centre " +
               std::to_string(self.offset()) + " px ahead of their midpoint>";
      });
}

void bind_blobs(py::module_& module) {
  py::class_<Blob>(module, "Blob", R"(
A connected component (8 neighbours) of pixels of one colour class, in pixels of its frame.
)")
      .def_readonly("color", &Blob::color, "str: name of the colour class.")
      .def_readonly("area", &Blob::area, "int: number of pixels.")
      .def_property_readonly(
          "centroid", [](const Blob& self) { return to_array(self.centroid); },
          "array (2,): mean (u, v) of its pixels.")
      .def_property_readonly(
          "bounding_box",
          [](const Blob& self) {
            return std::make_tuple(self.box.left, self.box.top, self.box.right - 1,
                                   self.box.bottom - 1);
          },
          "tuple of int: its outermost pixels (u_min, v_min, u_max, v_max), both ends included.")
      .def_readonly("at_border", &Blob::at_border,
                    "bool: it touches the edge of the frame, beyond which it may go on.")
      .def("__repr__", py::overload_cast<const Blob&>(&repr));

  const BlobOptions defaults;
  module.def("find_blobs", &find, py::arg("image"), py::arg("colors"), py::kw_only(),
             py::arg("markers") = py::none(), py::arg("minimum_area") = py::none(),
             py::arg("maximum_count") = py::none(), py::arg("smoothing") = py::none(),
             py::arg("region") = py::none(), R"(
Find the blobs of every colour class in one pass over an image.

Parameters
----------
image : Frame or array (H, W, 3) of uint8
    RGB; rows may lie at any distance in memory.
colors : list of ColorClass
    The colours to look for; a pixel may belong to several.
markers : MarkerLayout, optional
    The robot whose markers are looked for: the defaults of the other options are those with which
    they are found, in noise, too. Its lengths count as px of an array, or by the plane map of a
    Frame.
minimum_area : int, optional
    Smaller blobs are dropped (px). Default: 12, or an eighth of the smaller marker.
maximum_count : int, optional
    Only so many of the largest blobs of a colour are returned. Default: 64, or as the markers
    says.
smoothing : int, optional
    A pixel is judged by the mean of the window around it, so many px wide: 3, 5, ... 15, against
    noise; between a quarter and three quarters of a marker's width. 1 = by itself. Default: 1, or
    0.28 of the width of the smaller marker, at most 7.
region : tuple of int, optional
    (left, top, right, bottom) in px, all four included, as in a blob's bounding box: only these
    pixels are looked at, as if the image ended there. Places remain those in the whole image.

Returns
-------
dict of str to list of Blob
    Per colour the blobs, the largest first.

Raises
------
TypeError, ValueError
    For an image of another kind, for two colours of one name, and for options out of range.
)");

  module.def("classify", &masks_of, py::arg("image"), py::arg("colors"), py::kw_only(),
             py::arg("smoothing") = defaults.smoothing, R"(
Tell which pixels belong to which colour class: what `find_blobs` makes its blobs of.

Parameters
----------
image : Frame or array (H, W, 3) of uint8
    RGB; rows may lie at any distance in memory.
colors : list of ColorClass
    The colours; a pixel may belong to several.
smoothing : int
    A pixel is judged by the mean of so wide a window, as in `find_blobs`; 1 = by itself.

Returns
-------
dict of str to array (H, W) of bool
    Per colour, True for its pixels.

Raises
------
TypeError, ValueError
    For an image of another kind, for two colours of one name, and for options out of range.
)");
}

void bind_locate(py::module_& module) {
  py::class_<Measurement>(module, "Measurement", R"(
Where a robot was seen. A frame without a robot gives None instead.

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

  module.def(
      "locate",
      [](const BlobsByColor& blobs, const MarkerLayout& markers, const PlaneMap& plane_map) {
        return locate(blobs, markers, plane_map);
      },
      py::arg("blobs"), py::arg("markers"), py::arg("plane_map") = PlaneMap(), R"(
Return the pose of the robot whose markers are among the blobs.

It is that of the red-blue pair whose distance and areas fit. Blobs at the border of the frame are
not used: they may be cut off.

Parameters
----------
blobs : dict of str to list of Blob
    As from `find_blobs`; "red" and "blue" are looked at.
markers : MarkerLayout
    Where the robot carries its markers.
plane_map : PlaneMap, optional
    Pixels of the blobs' frame to work area. Default: the identity.

Returns
-------
Measurement or None
    None = not seen: no pair fits, or two fit equally well.
)");
}

void bind_color_training(py::module_& module, py::class_<ColorClass>& color_class) {
  const TrainingOptions defaults;
  color_class
      .def_static(
          "from_region",
          [](const py::object& image, const py::object& region, const py::str& name,
             double percentile, int margin, bool limit_y) {
            return color_from_histograms(name,
                                         color_histograms(view_of(image), region_from(region)),
                                         {percentile, margin, limit_y});
          },
          py::arg("image"), py::arg("region"), py::kw_only(), py::arg("name"),
          py::arg("percentile") = defaults.percentile, py::arg("margin") = defaults.margin,
          py::arg("limit_y") = defaults.limit_y, R"(
Return the colour class of a region of an image, such as that of a marker.

Parameters
----------
image : Frame or array (H, W, 3) of uint8
    RGB. Better one with little noise.
region : tuple of four ints
    Its outermost pixels (left, top, right, bottom), both ends included, as in
    `Blob.bounding_box`. Most of it must have the colour.
name : str
    Name of the colour.
percentile : float
    So many % of the pixels lie outside at each end of the range that is found in a channel.
margin : int
    What widens the ranges found (levels).
limit_y : bool
    Whether the class limits Y, too. Light and shadow change it, so by default any Y is right.

Raises
------
TypeError, ValueError
    For an image or a region of another kind, for a region that does not lie within the image,
    for options out of range, and if the region is grey, so that Y alone tells it: `limit_y`.

Notes
-----
Shadow and noise that is clipped at black and white take U and V towards neutral, 128, never away
from it. So a range that lies to one side of neutral is open at its far end. And the channel
farthest from neutral keeps 28 levels off it, or half of what it has: greys do not belong to the
class, however large the margin.
)")
      .def_static(
          "from_histograms",
          [](const py::object& histograms, const py::str& name, double percentile, int margin,
             bool limit_y) {
            return color_from_histograms(name, histograms_from(histograms),
                                         {percentile, margin, limit_y});
          },
          py::arg("histograms"), py::kw_only(), py::arg("name"),
          py::arg("percentile") = defaults.percentile, py::arg("margin") = defaults.margin,
          py::arg("limit_y") = defaults.limit_y, R"(
Return the colour class of regions with these histograms: those of several images add up.

Parameters
----------
histograms : array (3, 256)
    As from `color_histograms`, or a sum of such.
name, percentile, margin, limit_y
    As for `from_region`.
)")
      .def("widened", &widened, py::arg("margin"), R"(
Return the class with wider ranges.

Parameters
----------
margin : int
    By how many levels each end moves outwards; negative: inwards. Ends at 0 and 255 are open and
    stay.

Raises
------
ValueError
    If nothing is left of a range.
)");

  module.def("color_histograms", &histograms_of, py::arg("image"), py::arg("region"), R"(
Return how many pixels of a region have each value of Y, U and V.

Parameters
----------
image : Frame or array (H, W, 3) of uint8
    RGB.
region : tuple of four ints
    Its outermost pixels (left, top, right, bottom), both ends included.

Returns
-------
array (3, 256) of int64
    Rows Y, U, V. Those of several images add up.

Raises
------
TypeError, ValueError
    For an image or a region of another kind, or a region that does not lie within the image.
)");
}

}  // namespace

void bind_vision(py::module_& module) {
  py::class_<ColorClass> color_class(module, "ColorClass", R"(
A named colour: a pixel belongs to it when its Y, U and V lie within the ranges.

Parameters
----------
name : str
    Name of the colour.
y, u, v : tuple of two ints
    Lower and upper end of the range, both included, within 0..255.
)");
  color_class
      .def(py::init(&color_from), py::arg("name"), py::kw_only(), py::arg("y") = Range(0, 255),
           py::arg("u") = Range(0, 255), py::arg("v") = Range(0, 255))
      .def_readonly("name", &ColorClass::name, "str: name of the colour.")
      .def_property_readonly(
          "y", [](const ColorClass& self) { return range_of(self, 0); }, "tuple of int: luma.")
      .def_property_readonly(
          "u", [](const ColorClass& self) { return range_of(self, 1); },
          "tuple of int: blue minus luma, 128 = neutral.")
      .def_property_readonly(
          "v", [](const ColorClass& self) { return range_of(self, 2); },
          "tuple of int: red minus luma, 128 = neutral.")
      .def("__repr__", py::overload_cast<const ColorClass&>(&repr));

  module.def("rgb_to_yuv", &yuv_of, py::arg("image"), R"(
Return Y, U and V of every pixel, as the colour classes see them.

Full-range BT.601 in coefficients of 7 bits, rounded down: Y = (38 R + 75 G + 15 B)/128,
U = 128 + (-22 R - 42 G + 64 B)/128, V = 128 + (64 R - 54 G - 10 B)/128.

Parameters
----------
image : array (H, W, 3) of uint8
    RGB.

Returns
-------
array (H, W, 3) of uint8
    Y, U, V.
)");
  bind_color_training(module, color_class);
  bind_locator(module);
  bind_blobs(module);
  bind_locate(module);
}
