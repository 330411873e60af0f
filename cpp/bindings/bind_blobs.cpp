#include <tuple>

#include "python/interpreter.hpp"
#include "python/values.hpp"
#include "robsim/imaging/plane_map.hpp"
#include "robsim/vision/marker_width.hpp"
#include "robsim/vision/pixels/relative_classifier.hpp"

using namespace robsim;
using namespace robsim::bindings;

namespace {

using Box = std::tuple<int, int, int, int>;

Box box_of(const Blob& blob) {
  return {blob.box.left, blob.box.top, blob.box.right - 1, blob.box.bottom - 1};
}

Blob make_blob(const std::string& color, std::int64_t area, const Point& centroid,
               const PixelBox& bounding_box, bool at_border) {
  if (area < 1) throw py::value_error("area must be at least 1 px");
  const Blob blob{color, area, centroid, bounding_box, at_border};
  if (bounding_box.empty()) {
    throw py::value_error("bounding_box must have u_min <= u_max and v_min <= v_max, got " +
                          describe(py::cast(box_of(blob))));
  }
  return blob;
}

// A default finds any blobs, or with markers these.
BlobOptions options_for(const ImageLike& image, const std::optional<MarkerLayout>& markers) {
  return markers ? marker_blobs(*markers, image.plane_map(), image.view) : BlobOptions();
}

BlobsByColor find(const ImageLike& image, const std::vector<ColorClass>& colors,
                  const std::optional<MarkerLayout>& markers,
                  std::optional<std::int64_t> minimum_area, std::optional<int> maximum_count,
                  std::optional<int> smoothing, const std::optional<PixelBox>& region) {
  BlobOptions options = options_for(image, markers);
  options.minimum_area = minimum_area.value_or(options.minimum_area);
  options.maximum_count = maximum_count.value_or(options.maximum_count);
  options.smoothing = smoothing.value_or(options.smoothing);
  BlobFinder finder(colors, options);
  const WithoutInterpreter native;
  return finder.find(image.view,
                     region.value_or(PixelBox{0, 0, image.view.width, image.view.height}));
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
  pixels::RowClassifier classifier(colors,
                                   smoothing.value_or(options_for(image, markers).smoothing));
  classifier.begin(image.view);
  return masks_from(classifier, image.view, colors);
}

// The masks of the second chance, for tests.
Masks relative_masks_of(const ImageLike& image, const std::vector<ColorClass>& colors,
                        int smoothing, const light::Gains& gains, float least_chroma) {
  if (smoothing < 1 || smoothing > 15 || smoothing % 2 == 0) {
    throw py::value_error("smoothing must be 1, 3, ... 15 px, got " + std::to_string(smoothing));
  }
  std::vector<std::optional<light::RelativeClass>> classes;
  for (const ColorClass& color : colors) {
    classes.push_back(light::relative_to_brightness(color, least_chroma));
  }
  light::RelativeClassifier classifier(image.view, std::move(classes), smoothing, gains);
  return masks_from(classifier, image.view, colors);
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

Examples
--------
>>> frame = robsim.Simulation(seed=1).step().frame
>>> blob = robsim.find_blobs(frame, robsim.load_colors())["blue"][0]
>>> blob.area, blob.centroid.round(1), blob.at_border
(558, array([586. , 578.5]), False)
)");
  const Fields fields(
      &make_blob, Field("color", &Blob::color, "str: name of the colour class."), by_name,
      Field("area", &Blob::area, "int: number of pixels."),
      Field("centroid", &Blob::centroid, "array (2,): mean (u, v) of its pixels."),
      Field("bounding_box", &box_of, "tuple of int: (u_min, v_min, u_max, v_max), all included."),
      Field("at_border", &Blob::at_border,
            "bool: it touches the edge of the frame and may continue beyond it.", false));
  define_value(blob, fields);
  define_repr(blob,
              "<Blob {0.color}: area {0.area} px, "
              "centroid ({0.centroid[0]:.2f}, {0.centroid[1]:.2f})>");

  public_in(module, "robsim")
      .def("find_blobs", &find, "image"_a, "colors"_a, py::kw_only(), "markers"_a = py::none(),
           "minimum_area"_a = py::none(), "maximum_count"_a = py::none(),
           "smoothing"_a = py::none(), "region"_a = py::none(), R"(
Find the blobs of every colour class in one pass over an image.

Parameters
----------
image : Frame or array (H, W, 3) of uint8
    RGB; rows of any stride.
colors : list of ColorClass
    The colours to find; a pixel may belong to several.
markers : MarkerLayout, optional
    The markers to find: the other options then default to values that find these markers, also in
    noise. For an array, the layout's lengths are in px of the array; for a Frame, the plane map
    converts them.
minimum_area : int, optional
    Smaller blobs are dropped (px). Default: 12 without `markers`, otherwise 1/8 of the smaller
    marker's area.
maximum_count : int, optional
    Maximum number of blobs of a colour, the largest first. Default: 64 without `markers`, otherwise
    their `maximum_blobs`.
smoothing : int, optional
    Width of the window whose mean classifies a pixel, against noise: 3, 5, ... 15 px, between 1/4
    and 3/4 of a marker's width; 1 = off. Default: 1 without `markers`, otherwise 0.28 of the
    smaller marker's width, limited to 3..7. For a marker below 7 px, this default is 3 in images
    with noise and 1 in others.
region : tuple of int, optional
    (left, top, right, bottom) in px, all four included, as in a blob's bounding box: only these
    pixels are searched, as if the image ended there. Positions refer to the whole image.

Returns
-------
dict of str to list of Blob
    Per colour the blobs, the largest first.

Raises
------
TypeError, ValueError
    For an image of the wrong type or shape, duplicate colour names, and options out of range.

Examples
--------
>>> frame = robsim.Simulation(seed=1).step().frame
>>> blobs = robsim.find_blobs(frame, robsim.load_colors())
>>> {color: [blob.area for blob in found] for color, found in blobs.items()}
{'blue': [558], 'red': [3136, 558]}
)");

  public_in(module, "robsim._core")
      .def("relative_masks", &relative_masks_of, "image"_a, "colors"_a, "smoothing"_a, "gains"_a,
           "least_chroma"_a,
           "The pixels of each colour relative to brightness: the masks of the second chance.");

  public_in(module, "robsim.vision")
      .def("classify", &masks_of, "image"_a, "colors"_a, py::kw_only(), "markers"_a = py::none(),
           "smoothing"_a = py::none(), R"(
Return the pixels of each colour class: the masks for `find_blobs`.

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
    the default of `find_blobs` for the markers.

Returns
-------
dict of str to array (H, W) of bool
    Per colour, True for its pixels.

Raises
------
TypeError, ValueError
    For an image of the wrong type or shape, duplicate colour names, and options out of range.

Examples
--------
>>> frame = robsim.Simulation(seed=1).step().frame
>>> masks = robsim.vision.classify(frame, robsim.load_colors())
>>> {color: int(mask.sum()) for color, mask in masks.items()}  # pixels
{'blue': 558, 'red': 3694}
)");
}

}  // namespace

void bind_blobs(py::module_& module) { bind_find_blobs(module); }
