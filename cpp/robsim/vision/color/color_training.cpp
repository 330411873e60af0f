#include "robsim/vision/color/color_training.hpp"

#include <algorithm>
#include <numeric>
#include <stdexcept>

#include "robsim/text/to_text.hpp"

namespace robsim {

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

void check_margin(int margin, int minimum) {
  if (margin < minimum || margin > 255) {
    throw std::invalid_argument("margin must lie within " + std::to_string(minimum) +
                                "..255, got " + std::to_string(margin));
  }
}

void check_options(const TrainingOptions& options) {
  if (!(options.percentile >= 0 && options.percentile < 50)) {
    throw std::invalid_argument("percentile must be at least 0 and below 50 (%), got " +
                                to_text(options.percentile));
  }
  check_margin(options.margin, 0);
}

std::string text(const Range& range) {
  return std::to_string(range.lower) + ".." + std::to_string(range.upper);
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
                                 const TrainingOptions& options) {
  check_options(options);
  Range found[3];
  for (std::size_t i = 0; i < 3; ++i) found[i] = percentiles(histograms[i], options.percentile);
  const std::size_t strongest = chroma(found[1]) > chroma(found[2]) ? 1 : 2;
  const int strength = chroma(found[strongest]);
  const bool is_grey = strength < least_chroma(found[0]);
  if (is_grey && !options.limit_y) {
    throw std::invalid_argument(
        "the region has hardly any colour: U " + text(found[1]) + " and V " + text(found[2]) +
        " lie around 128, which is grey. Give a region within the marker, and more light if the "
        "marker is coloured; a black or white one is told by its brightness: limit_y=True");
  }
  const int kept = std::min(beyond_grey, strength / 2);
  Range ranges[3] = {{0, 255}, {0, 255}, {0, 255}};
  if (options.limit_y) ranges[0] = widened(found[0], options.margin);
  for (std::size_t i = 1; i < 3; ++i) {
    const bool stays_off_grey = i == strongest && !is_grey;
    const Range grey = stays_off_grey ? Range{neutral - kept, neutral + kept} : Range{255, 0};
    ranges[i] = chroma_range(found[i], options.margin, grey);
  }
  const ColorClass color{name,
                         {ranges[0].lower, ranges[1].lower, ranges[2].lower},
                         {ranges[0].upper, ranges[1].upper, ranges[2].upper}};
  check_color_class(color);
  return color;
}

ColorClass widened(const ColorClass& color, int margin) {
  check_margin(margin, -255);
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
