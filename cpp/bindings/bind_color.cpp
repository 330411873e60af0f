#include <algorithm>
#include <cmath>

#include "python/values.hpp"
#include "robsim/simulation/seam/thread_guard.hpp"
#include "robsim/vision/color/color_class.hpp"

using namespace robsim;
using namespace robsim::bindings;

namespace {

using Range = std::pair<int, int>;

constexpr double maximum_count = 1e15;  // of histograms: their sums are exact

ColorClass color_from(const py::str& name, Range y, Range u, Range v) {
  const ColorClass color{
      name_from(name), {y.first, u.first, v.first}, {y.second, u.second, v.second}};
  check_color_class(color);
  return color;
}

Range range_of(const ColorClass& color, std::size_t channel) {
  return {color.lower[channel], color.upper[channel]};
}

std::int64_t pixels_of(const ImageView& view) { return std::int64_t{view.width} * view.height; }

// Work on an image, without the interpreter if it is large.
template <typename Result, typename... P, typename... A>
Result worked(Result (*work)(const ImageView&, P...), const ImageView& image,
              const A&... arguments) {
  const NativeWork native(pixels_of(image));
  return work(image, arguments...);
}

py::array_t<std::uint8_t> yuv_of(const ImageView& view) {
  py::array_t<std::uint8_t> result({view.height, view.width, 3});
  std::uint8_t* to = result.mutable_data();
  const NativeWork work(pixels_of(view));
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

ColorHistograms histograms_from(const ArrayLike& histograms) {
  const std::string expected = "counts of shape (3, 256), as from color_histograms";
  const Doubles counts = doubles_from(histograms, "histograms", Shape{3, 256}, expected);
  ColorHistograms result{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t value = 0; value < 256; ++value) {
      const double count = counts.at(i, value);
      if (count < 0 || count > maximum_count || count != std::floor(count)) {
        throw py::value_error("histograms must be " + expected + ", got " + std::to_string(count));
      }
      result[i][value] = static_cast<std::int64_t>(count);
    }
  }
  return result;
}

py::array_t<std::int64_t> histograms_of(const ImageLike& image, const PixelBox& region) {
  const ColorHistograms histograms = worked(&color_histograms, image.view, region);
  py::array_t<std::int64_t> result({3, 256});
  for (std::size_t i = 0; i < 3; ++i) {
    std::copy(histograms[i].begin(), histograms[i].end(), result.mutable_data(i));
  }
  return result;
}

// Empty if the region is most of the image.
std::optional<SurroundingChroma> chroma_around(const ImageView& image, const PixelBox& region) {
  const double inside = static_cast<double>(region.right - region.left) *
                        static_cast<double>(region.bottom - region.top);
  const double all = static_cast<double>(image.width) * image.height;
  return inside < all / 4 ? std::optional(surrounding_chroma(image)) : std::nullopt;
}

// From medians and spreads of U and V.
std::optional<SurroundingChroma> around_from(const std::optional<ArrayLike>& around) {
  if (!around) return std::nullopt;
  const std::string expected =
      "medians and spreads of U and V, within 0..255, as from surrounding_chroma";
  const Doubles numbers = doubles_from(*around, "around", Shape{2, 2}, expected);
  const Eigen::Map<const Eigen::Array4d> all(numbers.data());
  if ((all < 0 || all > 255).any()) {
    throw py::value_error("around must be " + expected + ", got " +
                          describe(numbers.attr("tolist")()));
  }
  return SurroundingChroma{{all[0], all[1]}, {all[2], all[3]}};
}

void bind_training(py::module_& module, Class<ColorClass>& color_class) {
  const TrainingOptions defaults;
  color_class
      .def_static(
          "from_region",
          [](const ImageLike& image, const PixelBox& region, const py::str& name, double percentile,
             int margin, bool limit_y) {
            const std::string of = name_from(name);
            const NativeWork work(pixels_of(image.view));
            const ColorHistograms histograms = color_histograms(image.view, region);  // checks it
            return color_from_histograms(of, histograms, {percentile, margin, limit_y},
                                         chroma_around(image.view, region));
          },
          "image"_a, "region"_a, py::kw_only(), "name"_a, "percentile"_a = defaults.percentile,
          "margin"_a = defaults.margin, "limit_y"_a.noconvert() = defaults.limit_y, R"(
Return the colour class of a region of an image, such as a marker's.

Parameters
----------
image : Frame or array (H, W, 3) of uint8
    RGB, preferably with little noise.
region : tuple of four ints
    (left, top, right, bottom), all included, as in `Blob.bounding_box`. Most of the region must
    have the colour.
name : str
    Name of the colour: 1 to 40 letters, digits, spaces, - and _.
percentile : float
    Percentage of the pixels outside the range found in a channel, at each end.
margin : int
    Widening of the ranges found (levels).
limit_y : bool
    Whether the class limits Y, too. Light and shadow change Y, so by default any Y belongs.

Raises
------
TypeError, ValueError
    For an image or a region of the wrong type or shape, a region outside the image, or options out
    of range. Also raised for a grey region, which only Y can distinguish: see `limit_y`.

Notes
-----
Shadow, and noise clipped at black and white, move U and V towards neutral (128), never away from
it. So a range on one side of neutral is open at its far end. In the channel farthest from neutral,
the range stays 26 levels away from neutral, or half of the colour's distance if that is less. So
greys do not belong to the class, even with a large margin. A weak colour counts under two
conditions. First, the median of the region is farther from grey than the rest of the image. The
difference is at least 4 standard deviations of the mean of 7 x 7 pixels, and at least 3 levels.
Second, the distance from grey itself is at least as large, and at least 16 levels or 1/8 of the
luma, whichever is less.
)")
      .def_static(
          "from_histograms",
          [](const ArrayLike& histograms, const py::str& name, double percentile, int margin,
             bool limit_y, const std::optional<ArrayLike>& around) {
            return color_from_histograms(name_from(name), histograms_from(histograms),
                                         {percentile, margin, limit_y}, around_from(around));
          },
          "histograms"_a, py::kw_only(), "name"_a, "percentile"_a = defaults.percentile,
          "margin"_a = defaults.margin, "limit_y"_a.noconvert() = defaults.limit_y,
          "around"_a = py::none(), R"(
Return the colour class of regions with these histograms, which add up over images.

Parameters
----------
histograms : array (3, 256)
    As from `color_histograms`, or a sum of several.
name, percentile, margin, limit_y
    As for `from_region`.
around : array (2, 2), optional
    Medians and spreads of U and V around the regions, as from `surrounding_chroma`. Default: not
    known. A colour then counts if its distance from grey is at least 16 levels, or 1/4 of its luma
    if that is less.
)")
      .def("widened", &widened, "margin"_a, R"(
Return the class with wider ranges.

Parameters
----------
margin : int
    Outward shift of each limit (levels); a negative shift is inward. Limits at 0 and 255 are open
    and do not move.

Raises
------
ValueError
    If a range becomes empty.
)");

  public_in(module, "robsim.vision")
      .def(
          "surrounding_chroma",
          [](const ImageLike& image) {
            const SurroundingChroma found = worked(&surrounding_chroma, image.view);
            py::array_t<double> result({2, 2});
            std::copy_n(found.median.begin(), 2, result.mutable_data(0));
            std::copy_n(found.spread.begin(), 2, result.mutable_data(1));
            return result;
          },
          "image"_a, R"(
Return U and V of most of an image, which is the floor around the markers.

Parameters
----------
image : Frame or array (H, W, 3) of uint8
    RGB.

Returns
-------
array (2, 2)
    From the means over blocks of 7 x 7 pixels: the medians of U and V, and their spreads, half the
    distance between the 16th and the 84th percentile (levels).

Raises
------
TypeError, ValueError
    For an image of the wrong type or shape.

Examples
--------
>>> frame = robsim.Simulation(seed=1).step().frame
>>> medians, spreads = robsim.vision.surrounding_chroma(frame)
>>> medians.round()
array([125., 128.])
)")
      .def("color_histograms", &histograms_of, "image"_a, "region"_a, R"(
Return the number of pixels of a region with each value of Y, U and V.

Parameters
----------
image : Frame or array (H, W, 3) of uint8
    RGB.
region : tuple of four ints
    (left, top, right, bottom), all included.

Returns
-------
array (3, 256) of int64
    Rows Y, U, V. Add them up over several images.

Raises
------
TypeError, ValueError
    For an image or a region of the wrong type or shape, or a region outside the image.

Examples
--------
>>> image = np.full((4, 5, 3), 128, np.uint8)
>>> counts = robsim.vision.color_histograms(image, (0, 0, 2, 1))
>>> counts.argmax(axis=1), int(counts.max())  # Y, U, V; number of pixels
(array([128, 128, 128]), 6)
)");
}

}  // namespace

void bind_color(py::module_& module) {
  Class<ColorClass> color_class(public_in(module, "robsim"), "ColorClass", R"(
A named colour: a pixel belongs to the colour if the pixel's Y, U and V lie within the ranges.

Parameters
----------
name : str
    Name of the colour.
y, u, v : tuple of two ints
    Lower and upper end of the range, both included, within 0..255.

Examples
--------
>>> red = robsim.ColorClass("red", u=(60, 125), v=(180, 255))
>>> y, u, v = robsim.vision.rgb_to_yuv(np.uint8([[[200, 30, 40]]]))[0, 0]
>>> bool(red.u[0] <= u <= red.u[1] and red.v[0] <= v <= red.v[1])
True
)");
  const auto range = [](std::size_t channel) {
    return [channel](const ColorClass& color) { return range_of(color, channel); };
  };
  const Range all(0, 255);
  const Fields fields(&color_from, Field("name", &ColorClass::name, "str: name of the colour."),
                      by_name, Field("y", range(0), "tuple of int: luma.", all),
                      Field("u", range(1), "tuple of int: blue minus luma, 128 = neutral.", all),
                      Field("v", range(2), "tuple of int: red minus luma, 128 = neutral.", all));
  define_value(color_class, fields);
  define_repr(color_class, fields);

  public_in(module, "robsim.vision").def("rgb_to_yuv", &yuv_of, "image"_a, R"(
Return Y, U and V of every pixel, as for the colour classes.

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

Examples
--------
>>> robsim.vision.rgb_to_yuv(np.uint8([[[255, 0, 0], [128, 128, 128]]]))[0]
array([[ 75,  84, 255],
       [128, 128, 128]], dtype=uint8)
)");
  bind_training(module, color_class);
}
