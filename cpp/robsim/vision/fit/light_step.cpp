#include "robsim/vision/fit/light_step.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "robsim/base/elementary/elementary.hpp"
#include "robsim/base/geometry.hpp"
#include "robsim/base/simd/cpu_path.hpp"
#include "robsim/base/simd/lanes.hpp"
#include "robsim/base/simd/target.hpp"

namespace robsim::fit {

namespace {

// What a slope must be: so many variances, and a share of the contrast that is more than the rim of
// a marker gives.
constexpr double clear_slope = 12;
constexpr double visible_slope = 0.045;

// Sums over pixels of e = w . r, in terms of w; the normals of the edge stand for the place around
// the middle of the marker.
struct SlopeSums {
  double products[4];  // e f, f = normal_x, normal_y, T normal_x, T normal_y
  double squares[4];   // f^2
};

using simd::HalvedLanesOf;
using simd::LanesOf;
using Weights = std::array<float, 3>;

template <typename Floats>
ROBSIM_INLINE void add_slopes(const EdgeFit& marker, const Weights& weights, SlopeSums& result) {
  const Appearance& appearance = marker.appearance;
  float constant = 0, rise = 0;  // e = w . y - w . level - w . contrast T
  for (std::size_t c = 0; c < 3; ++c) {
    constant += weights[c] * static_cast<float>(appearance.level[c]);
    rise += weights[c] * static_cast<float>(appearance.contrast[c]);
  }
  Floats products[4], squares[4];
  for (int f = 0; f < 4; ++f) products[f] = squares[f] = Floats::all(0);
  for (const EdgeBlock& block : marker.pixels.blocks) {
    for (int i = 0; i < EdgeBlock::size; i += Floats::count) {
      const Floats t = Floats::load(block.coverage + i);
      Floats e = Floats::all(0) - Floats::all(constant) - Floats::all(rise) * t;
      for (std::size_t c = 0; c < 3; ++c) {
        e = e + Floats::all(weights[c]) * Floats::load(block.color[c] + i);
      }
      const Floats weight = Floats::load(block.weight + i);
      const Floats x = weight * Floats::load(block.normal_x + i);
      const Floats y = weight * Floats::load(block.normal_y + i);
      const Floats columns[4] = {x, y, t * x, t * y};
      for (int f = 0; f < 4; ++f) {
        products[f] = products[f] + e * columns[f];
        squares[f] = squares[f] + columns[f] * columns[f];
      }
    }
  }
  for (int f = 0; f < 4; ++f) {
    result.products[f] = sum_of(products[f]);
    result.squares[f] = sum_of(squares[f]);
  }
}

}  // namespace

bool has_light_slope(const EdgeFit& marker) {
  const Appearance& appearance = marker.appearance;
  // w_c = light of the marker / variance_c: what a change of light changes most
  Weights weights;
  std::array<double, 3> w;
  double rise = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const double light = EdgePixels::grey + appearance.level[c] + appearance.contrast[c];
    w[c] = std::max(light, 1.0) / (appearance.residuals[c][c] / appearance.ones + rounding);
    rise += w[c] * std::fabs(appearance.contrast[c]);
  }
  double variance = 0;  // of e = w . r
  for (std::size_t c = 0; c < 3; ++c) {
    weights[c] = static_cast<float>(w[c]);
    variance += w[c] * w[c] * rounding;
    for (std::size_t d = 0; d < 3; ++d)
      variance += w[c] * w[d] * appearance.residuals[c][d] / appearance.ones;
  }
  SlopeSums sums;
  ROBSIM_PICK(add_slopes<HalvedLanesOf<float>>, add_slopes<LanesOf<float>>)
  (marker, weights, sums);
  for (int f = 0; f < 4; ++f) {
    const double slope = std::fabs(sums.products[f]) / sums.squares[f];
    const double deviations = slope * slope * sums.squares[f] / variance;
    if (deviations > clear_slope && slope > visible_slope * rise) return true;
  }
  return false;
}

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

using Four = simd::LanesOf<float, 16>;

// Sums over the pixels of a side, or of those between two lines. z: what one appearance leaves of a
// channel, in its standard deviations.
struct SideSums {
  Four coverage = Four::all(0);           // 1, T, T^2
  Four residuals = Four::all(0);          // z of R, G, B
  Four residual_coverage = Four::all(0);  // z T

  SideSums& operator+=(const SideSums& other) {
    coverage = coverage + other.coverage;
    residuals = residuals + other.residuals;
    residual_coverage = residual_coverage + other.residual_coverage;
    return *this;
  }
  SideSums operator-(const SideSums& other) const {
    return {coverage - other.coverage, residuals - other.residuals,
            residual_coverage - other.residual_coverage};
  }

  double count() const { return static_cast<double>(coverage.at(0)); }

  // The sum of squares that the lines level + contrast T explain of z.
  double explained() const {
    float t[4], z[4], zt[4];
    coverage.store(t);
    residuals.store(z);
    residual_coverage.store(zt);
    const double by_count = 1 / static_cast<double>(t[0]);
    const double ones = static_cast<double>(t[0]), mean = static_cast<double>(t[1]) * by_count;
    // A side without an edge has a level alone.
    const double spread = static_cast<double>(t[2]) - static_cast<double>(t[1]) * mean;
    const double by_spread = spread > 1e-3 * ones ? 1 / spread : 0;
    double sum = 0;
    for (int c = 0; c < 3; ++c) {
      const auto of_level = static_cast<double>(z[c]);
      const double covariance = static_cast<double>(zt[c]) - mean * of_level;
      sum += of_level * of_level * by_count + covariance * covariance * by_spread;
    }
    return sum;
  }
};

// A pixel with its place in the box around the marker.
struct Pixel {
  float u, v;  // frame px
  SideSums sums;
};

std::vector<Pixel> pixels_of(const EdgeFit& marker, const std::array<double, 3>& variances) {
  const EdgePixels& pixels = marker.pixels;
  const Appearance& appearance = marker.appearance;
  float by_deviation[3], level[3], contrast[3];
  for (std::size_t c = 0; c < 3; ++c) {
    by_deviation[c] = static_cast<float>(1 / std::sqrt(variances[c]));
    level[c] = static_cast<float>(appearance.level[c]);
    contrast[c] = static_cast<float>(appearance.contrast[c]);
  }
  std::vector<Pixel> all;
  all.reserve(static_cast<std::size_t>(pixels.count));
  for (int i = 0; i < pixels.count; ++i) {
    const EdgeBlock& block = pixels.blocks[static_cast<std::size_t>(i / EdgeBlock::size)];
    const int k = i % EdgeBlock::size;
    const float t = block.coverage[k];
    float z[3];
    for (int c = 0; c < 3; ++c) {
      z[c] = (block.color[c][k] - level[c] - contrast[c] * t) * by_deviation[c];
    }
    all.push_back(
        {static_cast<float>(block.place[k] % pixels.stride),
         static_cast<float>(block.place[k] / pixels.stride),
         {Four(1, t, t * t, 0), Four(z[0], z[1], z[2], 0), Four(z[0] * t, z[1] * t, z[2] * t, 0)}});
  }
  return all;
}

struct Split {
  double angle = 0;   // rad, of the normal
  double offset = 0;  // frame px, in the box
  double gain = 0;    // what it explains beyond one appearance, in variances
};

// Looks for lines that divide the pixels of a marker.
class SplitSearch {
 public:
  SplitSearch(const EdgeFit& marker, const std::array<double, 3>& variances)
      : pixels_(pixels_of(marker, variances)),
        right_(static_cast<float>(marker.pixels.stride)),
        bottom_(static_cast<float>(marker.pixels.height)) {
    for (const Pixel& pixel : pixels_) all_ += pixel.sums;
  }

  double count() const { return all_.count(); }

  // The best line with a normal of this direction, of those a pixel apart.
  Split best(double angle) {
    const auto [sin, cos] = elementary::sin_cos(angle);
    const auto along_u = static_cast<float>(cos), along_v = static_cast<float>(sin);
    const float least = std::min(0.0F, along_u * right_) + std::min(0.0F, along_v * bottom_);
    const float most = std::max(0.0F, along_u * right_) + std::max(0.0F, along_v * bottom_);
    strips_.assign(static_cast<std::size_t>(most - least) + 1, {});
    for (const Pixel& pixel : pixels_) {
      strips_[static_cast<std::size_t>(pixel.u * along_u + pixel.v * along_v - least)] +=
          pixel.sums;
    }
    const double before = all_.explained();
    Split best;
    SideSums near;
    for (std::size_t i = 0; i + 1 < strips_.size(); ++i) {
      near += strips_[i];
      const SideSums beyond = all_ - near;
      if (near.count() < least_side || beyond.count() < least_side) continue;
      const double gain = near.explained() + beyond.explained() - before;
      if (gain > best.gain) {
        best = {angle, static_cast<double>(least) + static_cast<double>(i) + 1, gain};
      }
    }
    return best;
  }

 private:
  std::vector<Pixel> pixels_;
  float right_, bottom_;  // frame px, of the box
  SideSums all_;
  std::vector<SideSums> strips_;
};

}  // namespace

std::optional<LightStep> find_light_step(const EdgeFit& marker) {
  std::array<double, 3> variances;
  for (std::size_t c = 0; c < 3; ++c) {
    variances[c] = marker.appearance.residuals[c][c] / marker.appearance.ones + rounding;
  }
  SplitSearch search(marker, variances);
  if (search.count() < 2 * least_side) return std::nullopt;
  Split best;
  const auto look = [&](double angle) {
    const Split split = search.best(angle);
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
  const double change = best.gain / (3 * search.count()) * variance;  // square of it
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
