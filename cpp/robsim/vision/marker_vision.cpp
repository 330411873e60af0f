#include "robsim/vision/marker_vision.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "robsim/base/elementary/elementary.hpp"
#include "robsim/vision/color/color_class.hpp"
#include "robsim/vision/color/image_statistics.hpp"
#include "robsim/vision/fit/marker_shape.hpp"
#include "robsim/vision/marker_width.hpp"
#include "robsim/vision/pixels/relative_classifier.hpp"

namespace robsim {

namespace {

constexpr int margin = 2;    // px around the blob
constexpr double low = 0.2;  // share of the marker's colour that counts as none, and as all of it
constexpr double high = 0.8;
constexpr double drawing_variance = 0.02 * 0.02;  // px^2: pictures are not drawn more exactly

struct Chroma {
  double u = 0, v = 0;
};

Chroma chroma_at(const ImageView& image, int u, int v) {
  const Yuv yuv = rgb_to_yuv(image.row(v) + std::ptrdiff_t{3} * u);
  return {static_cast<double>(yuv.u), static_cast<double>(yuv.v)};
}

// The mean of 3 x 3 pixels, fewer at the border of the frame.
Chroma smoothed(const ImageView& image, int u, int v) {
  Chroma sum;
  int count = 0;
  for (int j = std::max(0, v - 1); j <= std::min(image.height - 1, v + 1); ++j) {
    for (int i = std::max(0, u - 1); i <= std::min(image.width - 1, u + 1); ++i, ++count) {
      const Chroma chroma = chroma_at(image, i, j);
      sum = {sum.u + chroma.u, sum.v + chroma.v};
    }
  }
  return {sum.u / count, sum.v / count};
}

Chroma middle_of(const std::vector<Chroma>& all) {
  std::vector<double> u, v;
  for (const Chroma& chroma : all) {
    u.push_back(chroma.u);
    v.push_back(chroma.v);
  }
  return {median_of(u), median_of(v)};
}

// Within the image. A box may lie anywhere: blobs need not be those of the image.
PixelBox grown(const PixelBox& box, int by, const ImageView& image) {
  const auto moved = [](int side, int way, int last) {
    return static_cast<int>(std::clamp<std::int64_t>(std::int64_t{side} + way, 0, last));
  };
  return {moved(box.left, -by, image.width), moved(box.top, -by, image.height),
          moved(box.right, by, image.width), moved(box.bottom, by, image.height)};
}

double length(int first, int last) { return static_cast<double>(last) - first; }

bool contains(const PixelBox& box, int u, int v) {
  return u >= box.left && u < box.right && v >= box.top && v < box.bottom;
}

}  // namespace

std::optional<WeightedCentroid> weighted_centroid(const ImageView& image, const PixelBox& blob,
                                                  const Point& middle) {
  const PixelBox box = grown(blob, margin, image);
  const PixelBox frame = grown(box, 1, image);
  std::vector<Chroma> around, within;
  for (int v = frame.top; v < frame.bottom; ++v) {
    for (int u = frame.left; u < frame.right; ++u) {
      if (!contains(box, u, v)) around.push_back(chroma_at(image, u, v));
      // the middle half of the blob's box lies in most markers
      const double x = std::fabs(2.0 * u + 1 - blob.left - blob.right);
      const double y = std::fabs(2.0 * v + 1 - blob.top - blob.bottom);
      const bool is_within =
          2 * x <= length(blob.left, blob.right) && 2 * y <= length(blob.top, blob.bottom);
      if (is_within) within.push_back(smoothed(image, u, v));
    }
  }
  if (around.empty() || within.empty()) return std::nullopt;
  const Chroma floor = middle_of(around);
  const Chroma marker = middle_of(within);
  const Chroma color{marker.u - floor.u, marker.v - floor.v};
  const double contrast = color.u * color.u + color.v * color.v;
  if (!(contrast > 1)) return std::nullopt;
  // The share of the marker's colour: its projection on the way from the floor's to it.
  const auto share = [&](const Chroma& seen) {
    return ((seen.u - floor.u) * color.u + (seen.v - floor.v) * color.v) / contrast;
  };
  double noise = 0;
  for (const Chroma& chroma : around) noise += share(chroma) * share(chroma);
  noise /= static_cast<double>(around.size());
  double sum = 0, sum_u = 0, sum_v = 0, moment = 0;
  for (int v = box.top; v < box.bottom; ++v) {
    for (int u = box.left; u < box.right; ++u) {
      const double weight =
          std::clamp((share(smoothed(image, u, v)) - low) / (high - low), 0.0, 1.0);
      sum += weight;
      sum_u += weight * u;
      sum_v += weight * v;
      // where the weight changes with the colour, at the edge
      if (weight > 0 && weight < 1) {
        const double x = u - middle.x;
        const double y = v - middle.y;
        moment += (x * x + y * y) / 2;
      }
    }
  }
  if (!(sum > 0)) return std::nullopt;
  // var(centroid) = sum (u - centroid)^2 var(weight) / (sum weights)^2. The mean over 3 x 3 divides
  // the variance of a weight by 9, and is 9 times as much of neighbours together.
  const double of_weight = noise / ((high - low) * (high - low));
  return WeightedCentroid{{sum_u / sum, sum_v / sum},
                          moment * of_weight / (sum * sum) + drawing_variance};
}

namespace {

// A fit whose markers end further from the blobs than this (frame px) has left them.
constexpr double farthest_from_blobs = 3;

double frame_scale(const Pose& pose, const PlaneMap& map) {
  return 1 / std::sqrt(map.area_scale(map.to_pixel({pose.x, pose.y})));
}

// By error propagation from the two centroids, whose variances (work-area px^2) are independent:
// heading = direction from second to first, place = their middle - R(heading) that of the layout.
PoseCovariance covariance_of(const MarkerPair& pair, const double (&variances)[2],
                             const MarkerLayout& markers, const PlaneMap& map, double heading) {
  const Point first = map.to_world(pair.first.centroid);
  const Point second = map.to_world(pair.second.centroid);
  const Point apart{first.x - second.x, first.y - second.y};
  const double squared = apart.x * apart.x + apart.y * apart.y;
  const double x = (markers.first.position.x + markers.second.position.x) / 2;
  const double y = (markers.first.position.y + markers.second.position.y) / 2;
  const auto [sin, cos] = elementary::sin_cos(heading);
  PoseCovariance covariance = PoseCovariance::Zero();
  for (int k = 0; k < 2; ++k) {
    const double sign = k == 0 ? 1 : -1;
    Eigen::Matrix<double, 3, 2> j;
    j.row(2) << -sign * apart.y / squared, sign * apart.x / squared;
    j.row(0) = (x * sin + y * cos) * j.row(2);
    j.row(1) = (-x * cos + y * sin) * j.row(2);
    j(0, 0) += 0.5;
    j(1, 1) += 0.5;
    covariance += variances[k] * (j * j.transpose());
  }
  return covariance;
}

// The pose by weighted centroids, where both blobs have a colour of their own.
void weigh(Measurement& measurement, const MarkerLayout& markers, const ImageView& image,
           const PlaneMap& map) {
  MarkerPair pair = *measurement.pair;
  double variances[2];
  Blob* const blobs[2] = {&pair.first, &pair.second};
  for (int k = 0; k < 2; ++k) {
    const auto found = weighted_centroid(image, blobs[k]->box, blobs[k]->centroid);
    if (!found) return;
    blobs[k]->centroid = found->centroid;
    variances[k] = found->variance * map.area_scale(found->centroid);
  }
  const Pose pose = pose_of(pair, markers, map);
  const PoseCovariance covariance = covariance_of(pair, variances, markers, map, pose.heading);
  if (!is_finite(pose) || !covariance.allFinite()) return;
  measurement.pose = pose;
  measurement.covariance = covariance;
}

bool is_good(const PoseFit& fit) { return fit.has_converged && fit.moved <= farthest_from_blobs; }

// A robot that is drawn at so many headings, and in whole pixels, is elsewhere than its picture by
// up to half of such a step: variance step^2/12.
void add_drawing(Measurement& measurement, const PlaneMap& map, int headings) {
  if (headings == 0 || !measurement.covariance) return;
  const double pixel = 1 / frame_scale(measurement.pose, map);
  const double turn = 2 * pi / headings;
  PoseCovariance& covariance = *measurement.covariance;
  covariance(0, 0) += pixel * pixel / 12;
  covariance(1, 1) += pixel * pixel / 12;
  covariance(2, 2) += turn * turn / 12;
}

// A misfit that noise alone does not make.
constexpr double unexplained = 3;

// Above this, blobs are no markers. It and the weights below divide 5000 pictures of robots, dark,
// faded, hidden, compressed or defined wrong, from videos and photos without one.
constexpr double most_unlike = -2.3;

// How little the blobs are like the outlines where the fit puts them.
double unlikeness(const Measurement& measurement, const PoseFit& fit, const MarkerLayout& markers,
                  const PlaneMap& map) {
  const auto [sin, cos] = elementary::sin_cos(measurement.pose.heading);
  double share = std::numeric_limits<double>::infinity();  // of an outline's area, the smaller one
  double fill = share;  // of a blob's box, relative to the outline's fill of its box
  for (const bool is_first : {true, false}) {
    const Blob& blob = is_first ? measurement.pair->first : measurement.pair->second;
    Polygon outline = (is_first ? markers.first : markers.second).shape->polygon();
    for (Point& corner : outline) {
      corner = map.to_pixel({measurement.pose.x + corner.x * cos - corner.y * sin,
                             measurement.pose.y + corner.x * sin + corner.y * cos});
    }
    const auto extent = [&](double Point::* part) {
      const auto [least, most] =
          std::minmax_element(outline.begin(), outline.end(),
                              [&](const Point& a, const Point& b) { return a.*part < b.*part; });
      return (*most).*part - (*least).*part;
    };
    const double box =
        length(blob.box.left, blob.box.right) * length(blob.box.top, blob.box.bottom);
    const double relative = static_cast<double>(blob.area) / polygon_area(outline);
    share = std::min(share, relative);
    fill = std::min(fill, relative * extent(&Point::x) * extent(&Point::y) / box);
  }
  const double left = fit.remainder / fit.signal_to_noise;
  return elementary::log(left / share) + fit.moved / 4 - 3 * fill;
}

// Refines a measurement in the image.
void refine(Detection& detection, const ImageView& image, const PlaneMap& map, int headings) {
  Measurement& measurement = *detection.measurement;
  const MarkerLayout& markers = detection.markers;
  std::optional<PoseFit> fit;
  if (markers.first.shape && markers.second.shape) {
    const bool is_first = markers.is_first_farther_right();
    const Marker& one = is_first ? markers.first : markers.second;
    const Marker& other = is_first ? markers.second : markers.first;
    fit = fit_pose(image, map, *one.shape, *other.shape, measurement.pose);
  }
  if (fit) {
    measurement.misfit = fit->misfit;
    measurement.signal_to_noise = fit->signal_to_noise;
  }
  if (fit && is_good(*fit)) {
    measurement.pose = fit->pose;
    measurement.covariance = fit->covariance;
  } else {
    weigh(measurement, markers, image, map);
    // What the outlines do not explain, the centroids feel, too.
    if (fit && measurement.covariance) {
      *measurement.covariance *= std::max(1.0, fit->misfit);
      if (fit->has_converged)
        add_doubt(measurement.pose, fit->pose, 1, *measurement.covariance, measurement.misfit);
    }
  }
  add_drawing(measurement, map, headings);
  if (measurement.signal_to_noise < least_signal_to_noise) {
    detection.result = DetectionResult::noise;
    detection.cause = measurement.signal_to_noise;
    detection.measurement.reset();
  } else if (fit && fit->remainder > unexplained &&
             unlikeness(measurement, *fit, markers, map) > most_unlike) {
    detection.result = DetectionResult::shape;
    detection.cause = fit->remainder;
    detection.measurement.reset();
  }
}

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

// The second chance: a robot found replaces the detection.
void look_again(Detection& detection, const ImageView& image, const std::vector<ColorClass>& colors,
                const PlaneMap& plane_map, std::optional<int> smoothing) {
  if (!deserves_another_look(detection)) return;
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
  look_at_grid({0, 0, image.width, image.height}, grid, grid, [&](int u, int v) {
    const std::uint8_t* rgb = image.row(v) + std::ptrdiff_t{3} * u;
    sum += rgb[0] + rgb[1] + rgb[2];
    white += std::min({rgb[0], rgb[1], rgb[2]}) >= white_level;
  });
  constexpr double count = grid * grid;
  return {sum / (3 * count), white / count};
}

// Light and shadow take the markers their colour, or part of their area.
bool may_be_light(DetectionResult result) {
  return result == DetectionResult::no_blobs || result == DetectionResult::no_first_blob ||
         result == DetectionResult::no_second_blob || result == DetectionResult::areas;
}

// The cause in the frame of a detection without a measurement.
void examine_frame(Detection& detection, const ImageView& image, const PlaneMap& plane_map) {
  if (detection.result == DetectionResult::at_border) return;
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
  if (detection.result == DetectionResult::noise || detection.result == DetectionResult::shape)
    return;  // measured at the markers
  const double width = marker_width(detection.markers, plane_map, image.width, image.height);
  const double noise = grey_noise(image);
  if (width < trusted_width(noise)) {
    set(DetectionResult::small_markers, width);
    detection.noise = noise;
  }
}

}  // namespace

Detection detect(const BlobsByColor& blobs, const MarkerLayout& markers, const Frame& frame,
                 const std::vector<ColorClass>& colors, std::optional<int> smoothing) {
  const ImageView image = frame.image.view();
  Detection detection = detect(blobs, markers, frame.plane_map);
  if (!detection.measurement && !colors.empty()) {
    look_again(detection, image, colors, frame.plane_map, smoothing);
  }
  if (detection.measurement) refine(detection, image, frame.plane_map, frame.headings);
  if (!detection.measurement) examine_frame(detection, image, frame.plane_map);
  return detection;
}

namespace {

BlobOptions with_smoothing(BlobOptions options, std::optional<int> smoothing) {
  if (smoothing) options.smoothing = *smoothing;
  return options;
}

}  // namespace

MarkerVision::MarkerVision(std::vector<ColorClass> colors, const MarkerLayout& markers,
                           std::optional<int> smoothing)
    : markers_(markers),
      smoothing_(smoothing),
      finder_(std::move(colors), with_smoothing({}, smoothing)) {}

BlobsByColor MarkerVision::find(const Frame& frame) {
  const ImageView image = frame.image.view();
  const BlobOptions options =
      with_smoothing(marker_blobs(markers_, frame.plane_map, image), smoothing_);
  if (!(options == finder_.options())) finder_ = BlobFinder(finder_.colors(), options);
  return finder_.find(image);
}

}  // namespace robsim
