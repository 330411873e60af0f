#include "robsim/vision/color/color_class.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "robsim/base/system.hpp"

namespace robsim {

void check_color_class(const ColorClass& color) {
  if (color.name.empty()) throw std::invalid_argument("name of a colour class must not be empty");
  const char* const channels[] = {"y", "u", "v"};
  for (std::size_t i = 0; i < 3; ++i) {
    if (color.lower[i] < 0 || color.lower[i] > color.upper[i] || color.upper[i] > 255) {
      throw std::invalid_argument(std::string(channels[i]) + " of colour class '" + color.name +
                                  "' must be a range within 0..255, lower end first, got [" +
                                  std::to_string(color.lower[i]) + ", " +
                                  std::to_string(color.upper[i]) + "]");
    }
  }
}

namespace {

constexpr int neutral = 128;

// Distance from neutral that grey hardly exceeds (levels): 3.7 standard deviations of the mean of
// 7 x 7 grey pixels in Gaussian noise of 40 %.
constexpr int beyond_grey = 26;

// Closer to neutral (levels), as floors and walls are, there is hardly any colour; where it is dark
// all colours are closer, in proportion to brightness, until the steps of 8 bits drown them.
constexpr int minimum_chroma = 16;
constexpr int minimum_dark_chroma = 6;
constexpr int chroma_per_luma = 4;  // a colour of less than 1/4 of its luma is greyish

// With what is around a region, its colour counts from so many standard deviations of the mean over
// a window on: half-way to it, where the limit of the class is, hardly any mean strays.
constexpr double deviations_out = 4;
constexpr double window_width = 7;           // px
constexpr double least_distance = 3;         // levels, below which rounding and compression count
constexpr double chroma_per_grey = 1.0 / 8;  // of its luma, which a colour has in any light

struct Range {
  int lower;
  int upper;
};

Range percentiles(const std::array<std::int64_t, 256>& counts, double percentile) {
  const auto total = std::accumulate(counts.begin(), counts.end(), std::int64_t{0});
  if (total == 0) throw std::invalid_argument("histograms must have pixels, got none");
  const double outside = percentile / 100 * static_cast<double>(total);
  Range range{0, 255};
  for (auto below = counts[0]; static_cast<double>(below) <= outside;) {
    below += counts[static_cast<std::size_t>(++range.lower)];
  }
  for (auto above = counts[255]; static_cast<double>(above) <= outside;) {
    above += counts[static_cast<std::size_t>(--range.upper)];
  }
  return range;
}

// Distance of a range from neutral; negative if it contains neutral.
int chroma(const Range& range) { return std::max(range.lower - neutral, neutral - range.upper); }

// The least distance from neutral of a colour of this luma.
int least_chroma(const Range& luma) {
  return std::clamp(luma.upper / chroma_per_luma, minimum_dark_chroma, minimum_chroma);
}

double median(const std::array<std::int64_t, 256>& counts) {
  const Range middle = percentiles(counts, 49.99);
  return (middle.lower + middle.upper) / 2.0;
}

// What is known of the colour of a region in the channel in which it is farthest from neutral.
struct Strength {
  std::size_t channel;
  int distance;        // from neutral (levels)
  bool is_grey;        // too little of it
  Range kept_out;      // values that the class must not take
  int off_grey = 0;    // the distance from neutral that a colour must have (levels)
  int off_around = 0;  // and from what is around it
};

// By the ranges found alone.
Strength strength_of(const Range* found) {
  const std::size_t channel = chroma(found[1]) > chroma(found[2]) ? 1 : 2;
  const int distance = chroma(found[channel]);
  const int kept = std::min(beyond_grey, distance / 2);
  const bool is_grey = distance < least_chroma(found[0]);
  return {channel, distance, is_grey, {neutral - kept, neutral + kept}};
}

// By the noise of the region and of what is around it: a colour is on the far side, seen from
// neutral, of what is around it, and the class ends half-way to both.
Strength strength_of(const ColorHistograms& histograms, const SurroundingChroma& around) {
  const double medians[] = {median(histograms[1]), median(histograms[2])};
  const std::size_t i = std::abs(medians[0] - neutral) > std::abs(medians[1] - neutral) ? 0 : 1;
  const double from_neutral = medians[i] - neutral;
  const double side = from_neutral < 0 ? -1 : 1;
  const double from_around = side * (medians[i] - around.median[i]);
  const Range most = percentiles(histograms[i + 1], 16);  // two standard deviations
  const double noise = (most.upper - most.lower) / 2.0 / window_width;
  const double off_around =
      std::max(deviations_out * std::max(noise, around.spread[i]), least_distance);
  const double off_grey = std::max(
      off_around, std::min<double>(minimum_chroma, chroma_per_grey * median(histograms[0])));
  const bool is_grey = side * from_neutral < off_grey || from_around < off_around;
  const int distance = static_cast<int>(side * from_neutral);
  const int kept = std::min(beyond_grey, distance / 2);
  Range kept_out{neutral - kept, neutral + kept};
  if (kept < beyond_grey) {
    const int half_way = static_cast<int>((medians[i] + around.median[i]) / 2);
    kept_out.lower = std::min(kept_out.lower, half_way);
    kept_out.upper = std::max(kept_out.upper, half_way);
  }
  const auto whole = [](double levels) { return static_cast<int>(std::ceil(levels)); };
  return {i + 1, distance, is_grey, kept_out, whole(off_grey), whole(off_around)};
}

Range widened(const Range& range, int margin) {
  return {range.lower > 0 ? std::clamp(range.lower - margin, 0, 255) : 0,
          range.upper < 255 ? std::clamp(range.upper + margin, 0, 255) : 255};
}

// The range of U or V: open away from neutral, widened by the margin towards neutral, but not into
// the range `grey`.
Range chroma_range(const Range& found, int margin, const Range& grey) {
  if (found.lower > neutral) return {std::max(found.lower - margin, grey.upper), 255};
  if (found.upper < neutral) return {0, std::min(found.upper + margin, grey.lower)};
  return widened(found, margin);
}

void check_options(const TrainingOptions& options) {
  checked(options.percentile, options.percentile >= 0 && options.percentile < 50,
          "percentile must be at least 0 and below 50 (%)");
  checked(options.margin, options.margin >= 0 && options.margin <= 255,
          "margin must lie within 0..255");
}

std::string text(const Range& range) {
  return std::to_string(range.lower) + ".." + std::to_string(range.upper);
}

[[noreturn]] void refuse(const Range* found, const Strength& strength,
                         const std::optional<SurroundingChroma>& around) {
  std::string sentence = "the region has hardly any colour: U " + text(found[1]) + " and V " +
                         text(found[2]) + " lie around 128, which is grey";
  if (around) {
    const auto of = [&](std::size_t i) { return std::to_string(std::lround(around->median[i])); };
    sentence += ", or around U " + of(0) + " and V " + of(1) + " of the rest of the picture; in " +
                "its noise and light a colour is " + std::to_string(strength.off_grey) +
                " levels off grey, and " + std::to_string(strength.off_around) +
                " farther than the rest";
  }
  throw std::invalid_argument(
      sentence +
      ". Give a region within the marker, and more light if the marker is coloured; a black or "
      "white one differs by its brightness: limit_y=True, in the shell --limit-y");
}

}  // namespace

ColorHistograms color_histograms(const ImageView& image, const PixelBox& region) {
  check_region(region, image);
  ColorHistograms histograms{};
  for (int v = region.top; v < region.bottom; ++v) {
    for (int u = region.left; u < region.right; ++u) {
      const Yuv yuv = rgb_to_yuv(image.row(v) + std::ptrdiff_t{3} * u);
      ++histograms[0][static_cast<std::size_t>(yuv.y)];
      ++histograms[1][static_cast<std::size_t>(yuv.u)];
      ++histograms[2][static_cast<std::size_t>(yuv.v)];
    }
  }
  return histograms;
}

ColorClass color_from_histograms(const std::string& name, const ColorHistograms& histograms,
                                 const TrainingOptions& options,
                                 const std::optional<SurroundingChroma>& around) {
  check_options(options);
  Range found[3];
  for (std::size_t i = 0; i < 3; ++i) found[i] = percentiles(histograms[i], options.percentile);
  const Strength strength = around ? strength_of(histograms, *around) : strength_of(found);
  if (strength.is_grey && !options.limit_y) refuse(found, strength, around);
  Range ranges[3] = {{0, 255}, {0, 255}, {0, 255}};
  if (options.limit_y) ranges[0] = widened(found[0], options.margin);
  for (std::size_t i = 1; i < 3; ++i) {
    const bool stays_off_grey = i == strength.channel && !strength.is_grey;
    const Range grey = stays_off_grey ? strength.kept_out : Range{255, 0};
    ranges[i] = chroma_range(found[i], options.margin, grey);
  }
  const ColorClass color{name,
                         {ranges[0].lower, ranges[1].lower, ranges[2].lower},
                         {ranges[0].upper, ranges[1].upper, ranges[2].upper}};
  check_color_class(color);
  return color;
}

ColorClass widened(const ColorClass& color, int margin) {
  checked(margin, std::abs(margin) <= 255, "margin must lie within -255..255");
  ColorClass result = color;
  for (std::size_t i = 0; i < 3; ++i) {
    const Range range = widened(Range{color.lower[i], color.upper[i]}, margin);
    result.lower[i] = range.lower;
    result.upper[i] = range.upper;
  }
  check_color_class(result);
  return result;
}

}  // namespace robsim
