#include "robsim/vision/marker_width.hpp"

#include <algorithm>
#include <cmath>

#include "robsim/base/elementary/elementary.hpp"
#include "robsim/base/geometry.hpp"
#include "robsim/vision/color/image_statistics.hpp"

namespace robsim {

namespace {

constexpr double good_contrast = 150;  // of red and blue on black; root of the squares over R, G, B
constexpr double sharp_edge = 0.6;     // frame px
constexpr double all_edge = 4.5;       // frame px; narrower markers stand out less
constexpr double least_width = 2;      // frame px
constexpr double rounding_noise = 0.3;  // levels: every picture has it

// Of markers of the width all_edge.
double signal_there(double noise) {
  const double perimeter = 2 * std::sqrt(pi) * all_edge;
  const double ratio = good_contrast / std::max(noise, rounding_noise);
  return std::sqrt(2 * ratio * ratio * perimeter * sharp_edge / 3.5);
}

}  // namespace

double expected_signal_to_noise(double width, double noise) {
  const double share = width / all_edge;
  const double is_seen = share < 1 ? share * share : 1;  // measured: rates of detection
  return signal_there(noise) * std::sqrt(share) * is_seen;
}

double trusted_width(double noise) {
  const double ratio = trusted_signal_to_noise / signal_there(noise);
  const double power = ratio < 1 ? 1 / 2.5 : 2;
  return std::max(least_width, all_edge * elementary::exp(power * elementary::log(ratio)));
}

namespace {

// 3 to 5 px find large markers as well; 7 px find fewer specks beside them in strong noise, which
// takes a third of the time. More would blur their shape.
constexpr double window_fraction = 0.28;      // of the marker's width
constexpr int minimum_window = 3;             // px
constexpr double maximum_window = 7;          // px
constexpr double minimum_fraction = 1.0 / 8;  // of the marker's area

// Of one pixel (levels). The shipped colour limits are 26 from grey: at a standard deviation of
// this, one grey pixel in 14 has the colour of a marker.
constexpr double noise_limit = 18;

// A corner of the frame may look beyond the floor, where a marker would be as small as one likes.
constexpr double least_far_width = 0.5;  // of the width in the middle

double width_at(const MarkerLayout& markers, const PlaneMap& plane_map, const Point& pixel) {
  const double marker = std::fmin(markers.first.area, markers.second.area);
  return std::sqrt(marker / plane_map.area_scale(pixel));
}

// The smallest width of the smaller marker in the frame.
double smallest_width(const MarkerLayout& markers, const PlaneMap& map, int width, int height) {
  const double middle = marker_width(markers, map, width, height);
  double smallest = middle;
  for (const double u : {0.0, width - 1.0}) {
    for (const double v : {0.0, height - 1.0}) {
      smallest = std::min(smallest, width_at(markers, map, {u, v}));
    }
  }
  return std::max(smallest, least_far_width * middle);
}

int odd_window(double width) {
  return 2 * static_cast<int>(std::min(width, maximum_window) / 2) + 1;
}

int window_for(double marker_width, const ImageView& image) {
  const int window = odd_window(window_fraction * marker_width);
  if (window >= minimum_window) return window;
  // It takes away the edge of a small marker, and in dim light the marker: it must be worth it.
  return pixels::chroma_noise(image) < noise_limit ? 1 : minimum_window;
}

}  // namespace

double marker_width(const MarkerLayout& markers, const PlaneMap& plane_map, int width, int height) {
  return width_at(markers, plane_map, {(width - 1) / 2.0, (height - 1) / 2.0});
}

BlobOptions marker_blobs(const MarkerLayout& markers, const PlaneMap& plane_map,
                         const ImageView& image) {
  BlobOptions options;
  options.maximum_count = markers.maximum_blobs;
  const double width = smallest_width(markers, plane_map, image.width, image.height);
  if (!std::isfinite(width)) return options;
  const double all = static_cast<double>(image.width) * image.height;
  options.smoothing = window_for(width, image);
  options.minimum_area =
      std::max<std::int64_t>(1, std::llround(std::min(minimum_fraction * width * width, all)));
  return options;
}

}  // namespace robsim
