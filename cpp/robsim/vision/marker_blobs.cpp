#include "robsim/vision/marker_blobs.hpp"

#include <algorithm>
#include <cmath>

namespace robsim {

namespace {

// Less than 1/4 of the marker's width does not help; 7 px suffice for the strongest noise, and more
// would blur the shape of large markers.
constexpr double window_fraction = 0.28;      // of the marker's width
constexpr double maximum_window = 7;          // px
constexpr double minimum_fraction = 1.0 / 8;  // of the marker's area

// The odd number of pixels nearest to a width.
int odd_window(double width) {
  return 2 * static_cast<int>(std::min(width, maximum_window) / 2) + 1;
}

}  // namespace

BlobOptions marker_blobs(const MarkerLayout& markers, const PlaneMap& plane_map, int width,
                         int height) {
  BlobOptions options;
  options.maximum_count = markers.maximum_blobs;
  const double marker = std::min(markers.red_area, markers.blue_area);
  const double scale = plane_map.area_scale({(width - 1) / 2.0, (height - 1) / 2.0});
  const double area = marker / scale;  // px^2 of the frame
  if (!std::isfinite(area)) return options;
  const double pixels = static_cast<double>(width) * height;
  options.smoothing = odd_window(window_fraction * std::sqrt(area));
  options.minimum_area =
      std::max<std::int64_t>(1, std::llround(std::min(minimum_fraction * area, pixels)));
  return options;
}

}  // namespace robsim
