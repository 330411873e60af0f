#include "robsim/vision/second_chance.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "robsim/vision/find_blobs.hpp"
#include "robsim/vision/light/relative_classifier.hpp"
#include "robsim/vision/marker_blobs.hpp"
#include "robsim/vision/pixels/chroma_noise.hpp"

namespace robsim {

namespace {

// A colour counts from so many standard deviations of a window's chroma on. With 2, poses are
// reported on empty floors in the strongest noise; with 3, markers are missed that 2.5 finds.
constexpr double least_deviations = 2.5;
constexpr double least_level = 1;  // of chroma, whatever the noise is: rounding makes half a level

// From this noise on (levels) pixels are smoothed, however small the markers are: the colours of
// dim markers are as weak as the noise of a single pixel.
constexpr double noise_to_smooth = 2;
constexpr int window_in_noise = 3;  // px

// In noise that would hide colours as faint as this (levels of chroma), the window is wider.
constexpr double faint = 12;
constexpr double wide_fraction = 0.4;  // of the marker's width
constexpr double widest_window = 9;    // px

// A floor whose chroma is this part of its brightness lies half-way to the limit of a colour.
constexpr double colored_floor = 0.07;

bool deserves_another_look(const Detection& detection) {
  switch (detection.result) {
    case DetectionResult::no_blobs:
    case DetectionResult::no_first_blob:
    case DetectionResult::no_second_blob:
    case DetectionResult::at_border:  // such as a floor that has the colour of a marker
    case DetectionResult::distance:
    case DetectionResult::areas:
      return true;
    default:
      return false;
  }
}

bool is_colored(const std::array<int, 3>& rgb) {
  const std::uint8_t bytes[] = {static_cast<std::uint8_t>(rgb[0]),
                                static_cast<std::uint8_t>(rgb[1]),
                                static_cast<std::uint8_t>(rgb[2])};
  const Yuv yuv = rgb_to_yuv(bytes);
  const int chroma = std::max(std::abs(yuv.u - 128), std::abs(yuv.v - 128));
  return chroma > colored_floor * *std::max_element(rgb.begin(), rgb.end());
}

// The blobs by colours relative to brightness, in light that these gains turn to white.
BlobsByColor relative_blobs(const ImageView& image, const std::vector<ColorClass>& colors,
                            const BlobOptions& options, double noise, const light::Gains& gains) {
  const double gain = *std::max_element(gains.begin(), gains.end());
  const double least_chroma =
      gain * std::max(least_deviations * noise / options.smoothing, least_level);
  std::vector<std::string> names;
  std::vector<std::optional<light::RelativeClass>> classes;
  for (const ColorClass& color : colors) {
    names.push_back(color.name);
    classes.push_back(light::relative_to_brightness(color, static_cast<float>(least_chroma)));
  }
  light::RelativeClassifier classifier(image, std::move(classes), options.smoothing, gains);
  BlobCollector collector(std::move(names), options);
  collector.begin({0, 0, image.width, image.height});
  for (int v = 0; v < image.height; ++v) collector.add_row(classifier.next_row());
  return collector.finish();
}

}  // namespace

void look_again(Detection& detection, const ImageView& image, const std::vector<ColorClass>& colors,
                const PlaneMap& plane_map, std::optional<int> smoothing) {
  if (detection.measurement || !deserves_another_look(detection)) return;
  const double noise = pixels::chroma_noise(image);
  BlobOptions options = marker_blobs(detection.markers, plane_map, image);
  if (noise > noise_to_smooth) options.smoothing = std::max(options.smoothing, window_in_noise);
  if (least_deviations * noise / options.smoothing > faint) {
    const double width = marker_width(detection.markers, plane_map, image.width, image.height);
    const double wide = std::fmin(wide_fraction * width, widest_window);
    options.smoothing = std::max(options.smoothing, 2 * static_cast<int>(wide / 2) + 1);
  }
  if (smoothing) options.smoothing = *smoothing;
  const std::array<int, 3> floor = light::floor_color(image);
  std::vector<light::Gains> whites = {{1, 1, 1}};
  if (is_colored(floor)) whites.push_back(light::gains_to_grey(floor));
  for (const light::Gains& gains : whites) {
    const BlobsByColor blobs = relative_blobs(image, colors, options, noise, gains);
    Detection found = detect(blobs, detection.markers, plane_map);
    if (!found.measurement) continue;
    found.by_second_chance = true;
    detection = found;
    return;
  }
}

}  // namespace robsim
