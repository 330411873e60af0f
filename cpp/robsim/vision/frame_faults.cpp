#include "robsim/vision/frame_faults.hpp"

#include <algorithm>

#include "robsim/imaging/grey_noise.hpp"
#include "robsim/vision/marker_blobs.hpp"
#include "robsim/vision/marker_signal.hpp"

namespace robsim {

namespace {

constexpr double dark_level = 64;          // mean of all channels, of 255
constexpr int white_level = 250;           // of all channels of a pixel
constexpr double overexposed_share = 0.5;  // of white pixels
constexpr int grid = 32;                   // pixels looked at, in each direction

struct Light {
  double mean_level = 0;
  double white_share = 0;
};

Light light_of(const ImageView& image) {
  double sum = 0;
  int white = 0;
  for (int row = 0; row < grid; ++row) {
    const std::uint8_t* pixels = image.row(row * (image.height - 1) / (grid - 1));
    for (int column = 0; column < grid; ++column) {
      const std::uint8_t* rgb = pixels + 3 * (column * (image.width - 1) / (grid - 1));
      sum += rgb[0] + rgb[1] + rgb[2];
      white += std::min({rgb[0], rgb[1], rgb[2]}) >= white_level;
    }
  }
  constexpr double count = grid * grid;
  return {sum / (3 * count), white / count};
}

// Light and shadow take the markers their colour, or part of their area.
bool may_be_light(DetectionResult result) {
  return result == DetectionResult::no_blobs || result == DetectionResult::no_first_blob ||
         result == DetectionResult::no_second_blob || result == DetectionResult::areas;
}

}  // namespace

void examine_frame(Detection& detection, const ImageView& image, const PlaneMap& plane_map) {
  if (detection.measurement || detection.result == DetectionResult::at_border) return;
  const auto set = [&](DetectionResult result, double cause) {
    detection.result = result;
    detection.cause = cause;
  };
  if (may_be_light(detection.result)) {
    const Light light = light_of(image);
    if (light.mean_level < dark_level) return set(DetectionResult::dark, light.mean_level);
    if (light.white_share > overexposed_share) {
      return set(DetectionResult::overexposed, light.white_share);
    }
  }
  if (detection.result == DetectionResult::noise) return;  // measured at the markers
  const double width = marker_width(detection.markers, plane_map, image.width, image.height);
  const double noise = grey_noise(image);
  if (width < trusted_width(noise)) {
    set(DetectionResult::small_markers, width);
    detection.noise = noise;
  }
}

}  // namespace robsim
