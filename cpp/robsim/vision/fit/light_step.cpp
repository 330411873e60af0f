#include "robsim/vision/fit/light_step.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "robsim/elementary/sine.hpp"
#include "robsim/geometry/pose.hpp"

namespace robsim::fit {

namespace {

constexpr int directions = 8;      // that are tried first, over half a turn
constexpr int refinements = 2;     // halvings of the angle between them
constexpr double least_side = 30;  // pixels
constexpr double half_band = 1.5;  // frame px: how far from the line pixels are left out

// What a line must explain: so many variances of the residuals, which chance does not give (two
// appearances have 6 numbers more than one, and some 100 lines are independent), and a change that
// matters beside the contrast, as none does that comes from how pictures are drawn.
constexpr double clear_gain = 36;
constexpr double visible_change = 0.03;  // root mean square, as a share of the contrast

// Sums over the pixels of a side, or of those between two lines.
struct SideSums {
  double count = 0, coverage = 0, squares = 0;      // 1, T, T^2
  std::array<double, 3> color{}, color_coverage{};  // y, y T

  SideSums& operator+=(const SideSums& other) {
    count += other.count;
    coverage += other.coverage;
    squares += other.squares;
    for (std::size_t c = 0; c < 3; ++c) {
      color[c] += other.color[c];
      color_coverage[c] += other.color_coverage[c];
    }
    return *this;
  }
  SideSums operator-(const SideSums& other) const {
    SideSums rest = *this;
    rest.count -= other.count;
    rest.coverage -= other.coverage;
    rest.squares -= other.squares;
    for (std::size_t c = 0; c < 3; ++c) {
      rest.color[c] -= other.color[c];
      rest.color_coverage[c] -= other.color_coverage[c];
    }
    return rest;
  }

  // The sum of squares that the line level + contrast T explains, each channel in its variances.
  double explained(const std::array<double, 3>& variances) const {
    const double spread = squares - coverage * coverage / count;
    double sum = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const double covariance = color_coverage[c] - coverage * color[c] / count;
      double of_channel = color[c] * color[c] / count;
      // A side without an edge has a level alone.
      if (spread > 1e-3 * count) of_channel += covariance * covariance / spread;
      sum += of_channel / variances[c];
    }
    return sum;
  }
};

// A pixel with its place in the box around the marker.
struct Pixel {
  double u, v;  // frame px
  SideSums sums;
};

std::vector<Pixel> pixels_of(const EdgePixels& pixels) {
  std::vector<Pixel> all;
  all.reserve(static_cast<std::size_t>(pixels.count));
  for (int i = 0; i < pixels.count; ++i) {
    const EdgeBlock& block = pixels.blocks[static_cast<std::size_t>(i / EdgeBlock::size)];
    const int k = i % EdgeBlock::size;
    const auto t = static_cast<double>(block.coverage[k]);
    Pixel pixel{static_cast<double>(block.place[k] % pixels.stride),
                static_cast<double>(block.place[k] / pixels.stride),
                {1, t, t * t, {}, {}}};
    for (std::size_t c = 0; c < 3; ++c) {
      const auto y = static_cast<double>(block.color[c][k]);
      pixel.sums.color[c] = y;
      pixel.sums.color_coverage[c] = y * t;
    }
    all.push_back(pixel);
  }
  return all;
}

struct Split {
  double angle = 0;   // rad, of the normal
  double offset = 0;  // frame px, in the box
  double gain = 0;    // what it explains beyond one appearance, in variances
};

// The best line with a normal of this direction, of those a pixel apart.
Split best_split(const std::vector<Pixel>& pixels, const SideSums& all, double angle,
                 const std::array<double, 3>& variances) {
  const auto [sin, cos] = elementary::sin_cos(angle);
  double least = 1e9, most = -1e9;
  for (const Pixel& pixel : pixels) {
    const double along = pixel.u * cos + pixel.v * sin;
    least = std::min(least, along);
    most = std::max(most, along);
  }
  std::vector<SideSums> strips(static_cast<std::size_t>(most - least) + 1);
  for (const Pixel& pixel : pixels) {
    strips[static_cast<std::size_t>(pixel.u * cos + pixel.v * sin - least)] += pixel.sums;
  }
  const double before = all.explained(variances);
  Split best;
  SideSums near;
  for (std::size_t i = 0; i + 1 < strips.size(); ++i) {
    near += strips[i];
    const SideSums beyond = all - near;
    if (near.count < least_side || beyond.count < least_side) continue;
    const double gain = near.explained(variances) + beyond.explained(variances) - before;
    if (gain > best.gain) best = {angle, least + static_cast<double>(i) + 1, gain};
  }
  return best;
}

}  // namespace

std::optional<LightStep> find_light_step(const EdgeFit& marker) {
  const std::vector<Pixel> pixels = pixels_of(marker.pixels);
  SideSums all;
  for (const Pixel& pixel : pixels) all += pixel.sums;
  if (all.count < 2 * least_side) return std::nullopt;
  std::array<double, 3> variances;
  for (std::size_t c = 0; c < 3; ++c) {
    variances[c] = marker.appearance.residuals[c][c] / marker.appearance.ones + rounding;
  }
  Split best;
  const auto look = [&](double angle) {
    const Split split = best_split(pixels, all, angle, variances);
    if (split.gain > best.gain) best = split;
  };
  double apart = pi / directions;
  for (int i = 0; i < directions; ++i) look(i * apart);
  for (int i = 0; i < refinements; ++i) {
    apart /= 2;
    const double angle = best.angle;
    look(angle - apart);
    look(angle + apart);
  }
  double variance = 0, contrast = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    variance += variances[c];
    contrast += marker.appearance.contrast[c] * marker.appearance.contrast[c];
  }
  // What one appearance leaves is a variance for each pixel and channel.
  const double change = best.gain / (3 * all.count) * variance;  // square of it
  if (best.gain < clear_gain || change < visible_change * visible_change * contrast)
    return std::nullopt;
  const auto [sin, cos] = elementary::sin_cos(best.angle);
  return LightStep{cos, sin,
                   best.offset + marker.pixels.left * cos + marker.pixels.top * sin - 0.5};
}

std::array<EdgePixels, 2> divided(const EdgePixels& pixels, const LightStep& step) {
  EdgePixels none;
  none.left = pixels.left;
  none.top = pixels.top;
  none.stride = pixels.stride;
  none.height = pixels.height;
  none.scale = pixels.scale;
  std::array<EdgePixels, 2> sides{none, none};
  for (int i = 0; i < pixels.count; ++i) {
    const EdgeBlock& block = pixels.blocks[static_cast<std::size_t>(i / EdgeBlock::size)];
    const int k = i % EdgeBlock::size;
    const double u = pixels.left + block.place[k] % pixels.stride;
    const double v = pixels.top + block.place[k] / pixels.stride;
    const double beyond = u * step.normal_u + v * step.normal_v - step.offset;
    if (std::fabs(beyond) < half_band) continue;
    sides[beyond > 0 ? 1 : 0].add(block, k);
  }
  return sides;
}

}  // namespace robsim::fit
