#include "robsim/vision/fit/edge_fit.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "robsim/base/simd/cpu_path.hpp"
#include "robsim/base/simd/lanes.hpp"
#include "robsim/base/simd/target.hpp"
#include "robsim/vision/color/image_statistics.hpp"

namespace robsim::fit {

namespace {

constexpr double shading = 10;  // levels by which all channels may be lighter at once

// Residuals that are further from 0 than about this have little weight: in standard deviations, and
// as a share of the contrast for pictures without noise.
constexpr double robust_deviations = 3;
constexpr double robust_contrast = 0.06;

}  // namespace

bool EdgeFit::update(const EdgeShift& shift) {
  weights.gain = 0;
  if (pixels.count < 12 || !cover(pixels, shift, appearance)) return false;
  // C: covariance of the residuals over R, G, B. Two numbers are fitted to each channel.
  using Matrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  Eigen::Matrix3d covariance =
      Eigen::Map<const Matrix>(appearance.residuals[0].data()) / std::max(1.0, appearance.ones - 2);
  covariance.diagonal().array() += rounding;
  // weights = (C + shading^2 1 1')^-1 contrast: light and shadow change all channels alike.
  const Eigen::Map<const Eigen::Vector3d> contrast(appearance.contrast.data());
  const Eigen::Map<const Eigen::Vector3d> level(appearance.level.data());
  Eigen::Map<Eigen::Vector3d> m(weights.of.data());
  m = (covariance + Eigen::Matrix3d::Constant(shading * shading)).inverse() * contrast;
  variance = m.dot(covariance * m);
  const double gain = contrast.dot(m);
  if (!(variance > 0 && std::isfinite(gain) && gain > 0)) return false;
  weights.gain = gain;
  weights.constant = level.dot(m);
  sums = sums_of(pixels, shift, appearance, weights);
  return true;
}

std::vector<float> EdgeFit::residuals() const {
  std::vector<float> all(pixels.blocks.size() * EdgeBlock::size);
  float* z = all.data();
  const auto number = [](double value) { return static_cast<float>(value); };
  const float m[3] = {number(weights.of[0]), number(weights.of[1]), number(weights.of[2])};
  const float constant = number(weights.constant);
  const float rise = number(weights.gain);  // z = m . y - m . level - gain T
  for (const EdgeBlock& block : pixels.blocks) {
    for (int i = 0; i < EdgeBlock::size; ++i) {
      const float y =
          m[0] * block.color[0][i] + m[1] * block.color[1][i] + m[2] * block.color[2][i];
      z[i] = y - constant - rise * block.coverage[i];
    }
    z += EdgeBlock::size;
  }
  std::fill(all.begin() + pixels.count, all.end(), 0.0F);
  return all;
}

double EdgeFit::usual_residual() const {
  std::vector<float> sizes = residuals();
  sizes.resize(static_cast<std::size_t>(pixels.count));
  for (float& size : sizes) size = std::fabs(size);
  return static_cast<double>(median_of(sizes)) / weights.gain;
}

void EdgeFit::weigh_by_residual() {
  const std::vector<float> z = residuals();
  // The median of |z| of a normal distribution is 0.6745 standard deviations.
  const double deviation = std::max(usual_residual() / 0.6745, robust_contrast);
  const auto limit = static_cast<float>(robust_deviations * deviation * weights.gain);
  for (std::size_t i = 0; i < static_cast<std::size_t>(pixels.count); ++i) {
    // root of the weight 1 / (1 + (z/limit)^2)^2
    const float share = z[i] / limit;
    pixels.blocks[i / EdgeBlock::size].weight[i % EdgeBlock::size] = 1 / (1 + share * share);
  }
}

namespace {

// The neighbours of a pixel up to 2 px away, each pair once: right, and in the rows below.
struct Lag {
  int u, v;
};
constexpr Lag lags[] = {{1, 0}, {2, 0},  {-2, 1}, {-1, 1}, {0, 1}, {1, 1},
                        {2, 1}, {-2, 2}, {-1, 2}, {0, 2},  {1, 2}, {2, 2}};
constexpr int reach = 2;
static_assert(reach <= EdgePixels::gap);

// More than this many standard deviations is no chance.
constexpr double significant = 3;

// Numbers of the pixels of a box, 0 where there is none, with so many zeros around that neighbours
// are found by their distance in memory. Whole numbers: their sums are exact in any order, so that
// compilers may vectorise them.
class Grid {
 public:
  /// `numbers_of` writes those of a block.
  template <typename NumbersOf>
  Grid(const EdgePixels& pixels, NumbersOf numbers_of)
      : stride_(pixels.stride),
        height_(pixels.height),
        numbers_(static_cast<std::size_t>(stride_ * (height_ + reach) + reach)) {
    int left = pixels.count;
    std::int16_t numbers[EdgeBlock::size];
    for (const EdgeBlock& block : pixels.blocks) {
      numbers_of(block, numbers);
      const int count = std::min(left, EdgeBlock::size);
      for (int k = 0; k < count; ++k)
        numbers_[static_cast<std::size_t>(block.place[k])] = numbers[k];
      left -= count;
    }
  }

  int stride() const { return stride_; }
  int count() const { return stride_ * height_; }  // those of the box
  const std::int16_t* data() const { return numbers_.data(); }

 private:
  int stride_, height_;
  std::vector<std::int16_t> numbers_;
};

// So large that the sum of so many products does not overflow.
constexpr int most_number = 256;
constexpr int most_products = 1 << 14;
constexpr auto most = static_cast<float>(most_number);

void round_block(const float (&values)[EdgeBlock::size], std::int16_t* numbers) {
  using Floats = simd::LanesOf<float, 16>;
  float raised[EdgeBlock::size];  // above 0, where to round is to cut off
  for (int k = 0; k < EdgeBlock::size; k += Floats::count) {
    const Floats near = within(Floats::load(values + k), Floats::all(-most), Floats::all(most));
    (near + Floats::all(most + 0.5F)).store(raised + k);
  }
  for (int k = 0; k < EdgeBlock::size; ++k) {
    numbers[k] = static_cast<std::int16_t>(static_cast<std::int32_t>(raised[k]) - most_number);
  }
}

ROBSIM_INLINE double product(const Grid& grid, int offset) {
  std::int64_t sum = 0;
  for (int start = 0; start < grid.count(); start += most_products) {
    const std::int16_t* numbers = grid.data() + start;
    const int count = std::min(most_products, grid.count() - start);
    std::int32_t of_part = 0;
    for (int i = 0; i < count; ++i) of_part += numbers[i] * numbers[i + offset];
    sum += of_part;
  }
  return static_cast<double>(sum);
}

// The sum of the products of all pixels with their neighbour there.
double product_with(const Grid& grid, const Lag& lag) {
  return ROBSIM_PICK(product)(grid, lag.v * grid.stride() + lag.u);
}

double product_with(const std::vector<Grid>& grids, const Lag& lag) {
  double sum = 0;
  for (const Grid& grid : grids) sum += product_with(grid, lag);
  return sum;
}

Grid ones_of(const EdgePixels& pixels) {
  return Grid(pixels, [](const EdgeBlock&, std::int16_t* numbers) {
    std::fill_n(numbers, EdgeBlock::size, std::int16_t{1});
  });
}

// z in standard deviations, to 1/32; more than 8 count as 8.
Grid residuals_of(const EdgeFit& marker) {
  const std::vector<float> z = marker.residuals();
  const float* of_block = z.data();
  const auto unit = static_cast<float>(32 / std::sqrt(marker.variance));
  return Grid(marker.pixels, [&](const EdgeBlock& block, std::int16_t* numbers) {
    float scaled[EdgeBlock::size];
    for (int k = 0; k < EdgeBlock::size; ++k) scaled[k] = of_block[k] * block.weight[k] * unit;
    round_block(scaled, numbers);
    of_block += EdgeBlock::size;
  });
}

Grid slopes_of(const EdgePixels& pixels) {
  return Grid(pixels, [](const EdgeBlock& block, std::int16_t* numbers) {
    float scaled[EdgeBlock::size];
    for (int k = 0; k < EdgeBlock::size; ++k) scaled[k] = 480 * block.slope[k];
    round_block(scaled, numbers);
  });
}

// How alike the slopes of pixels and their neighbours are. Their directions are taken to be the
// same: an edge hardly turns in 2 px.
class SlopeCorrelation {
 public:
  explicit SlopeCorrelation(const std::vector<EdgeFit>& parts) {
    for (const EdgeFit& part : parts) {
      grids_.push_back(slopes_of(part.pixels));
      all_ += product_with(grids_.back(), {0, 0});
    }
  }
  double at(const Lag& lag) const { return product_with(grids_, lag) / all_; }

 private:
  std::vector<Grid> grids_;
  double all_ = 0;
};

}  // namespace

double variance_factor(const std::vector<EdgeFit>& parts) {
  std::vector<Grid> residuals;
  double count = 0;
  for (const EdgeFit& part : parts) {
    residuals.push_back(residuals_of(part));
    count += part.pixels.count;
  }
  const double variance = product_with(residuals, {0, 0}) / count;
  if (!(variance > 0)) return 1;
  double factor = 1;
  std::vector<Grid> ones;  // made if they are needed
  std::vector<SlopeCorrelation> slopes;
  for (const Lag& lag : lags) {
    const double sum = product_with(residuals, lag);
    // In a ring of this width at least 6 in 10 pixels have a neighbour there.
    if (std::fabs(sum) < significant * variance * std::sqrt(0.6 * count)) continue;
    if (ones.empty()) {
      for (const EdgeFit& part : parts) ones.push_back(ones_of(part.pixels));
    }
    const double pairs = product_with(ones, lag);
    const double correlation = sum / (pairs * variance);
    if (!(std::fabs(correlation) * std::sqrt(pairs) > significant)) continue;
    if (slopes.empty()) slopes.emplace_back(parts);
    // var(D'z) = sum_ij D_i D_j cov(z_i, z_j)
    factor += 2 * correlation * slopes.front().at(lag);
  }
  return std::max(1.0, factor);
}

}  // namespace robsim::fit
