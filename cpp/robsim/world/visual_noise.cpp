#include "robsim/world/visual_noise.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "robsim/base/elementary/elementary.hpp"
#include "robsim/base/system.hpp"
#include "robsim/world/add_noise.hpp"

namespace robsim {

namespace {

constexpr int maximum_step = 255;  // larger ones clip to the same bytes
constexpr int nodes = 15;          // on each side of 0, besides the tail
constexpr int narrow_nodes = 8;
constexpr int maximum_mask_bits = 5;
constexpr int columns = 16;      // of the alias table
constexpr int resolution = 256;  // of the weight of a column
constexpr int tail_count = 1;    // share of the tail, of columns * resolution
constexpr int iterations = 200;  // of the fit

// P(|n| > x) of a standard normal number n, x >= 0, with a relative error of less than 1e-13.
// Series and continued fraction: Abramowitz and Stegun 1964, 26.2.11 and 26.2.14.
double two_sided_tail(double x) {
  constexpr double sqrt_2_pi = 2.5066282746310002;
  const double density = elementary::exp(-x * x / 2) / sqrt_2_pi;
  if (x < 2.5) {
    // P(|n| < x) = 2 density (x + x^3/3 + x^5/(3 5) + ...)
    double sum = 0;
    double term = x;
    for (int n = 3; sum + term != sum; n += 2) {
      sum += term;
      term *= x * x / n;
    }
    return 1 - 2 * density * sum;
  }
  // 2 density/(x + 1/(x + 2/(x + 3/(x + ...))))
  constexpr int levels = 150;
  double denominator = x;
  for (int n = levels; n >= 1; --n) denominator = x + n / denominator;
  return 2 * density / denominator;
}

// The target: P(|step| = k) for k = 0..255, the tail included in the last.
std::vector<double> target_distribution(double deviation) {
  std::vector<double> probability(maximum_step + 1);
  double outside = 1;
  for (int k = 0; k <= maximum_step; ++k) {
    const double next = k == maximum_step ? 0 : two_sided_tail((k + 0.5) / deviation);
    probability[static_cast<std::size_t>(k)] = outside - next;
    outside = next;
  }
  return probability;
}

// Takes the outermost share out of a distribution, for the tail.
std::vector<double> take_tail(std::vector<double>& probability) {
  std::vector<double> tail(probability.size(), 0.0);
  double rest = double(tail_count) / (columns * resolution);
  for (std::size_t k = probability.size(); rest > 0 && k-- > 0;) {
    tail[k] = std::min(probability[k], rest);
    probability[k] -= tail[k];
    rest -= tail[k];
  }
  return tail;
}

void fill_tail(const std::vector<double>& tail, GaussianTables& tables) {
  constexpr double total = double(tail_count) / (columns * resolution);
  constexpr double highest = std::numeric_limits<std::uint32_t>::max();
  tables.tail_first = 0;
  while (tail[static_cast<std::size_t>(tables.tail_first)] == 0) ++tables.tail_first;
  double outside = 0;
  for (std::size_t k = tail.size(); k-- > 0;) {
    tables.beyond[k] = static_cast<std::uint32_t>(std::min(highest * outside / total, highest));
    outside += tail[k];
  }
}

// P(|step| = k) given the node.
std::vector<double> node_distribution(int node, int mask) {
  std::vector<double> probability(maximum_step + 1, 0.0);
  const int count = mask + 1;
  for (int difference = -mask; difference <= mask; ++difference) {
    const double weight = double(count - std::abs(difference)) / (double(count) * count);
    const int step = std::min(std::abs(node + difference), maximum_step);
    probability[static_cast<std::size_t>(step)] += weight;
  }
  return probability;
}

// The weights of the nodes whose mixture is closest to the target.
// Method: expectation-maximisation for the weights of a mixture (Dempster, Laird and Rubin 1977).
std::vector<double> fitted_weights(const GaussianTables& tables,
                                   const std::vector<double>& target) {
  std::vector<std::vector<double>> part;
  for (std::size_t i = 0; i < nodes; ++i) {
    part.push_back(node_distribution(tables.node[i], tables.mask[i]));
  }
  std::vector<double> weight(nodes, 1.0 / nodes);
  for (int iteration = 0; iteration < iterations; ++iteration) {
    std::vector<double> factor(nodes, 0.0);
    for (std::size_t k = 0; k <= maximum_step; ++k) {
      double mixture = 0;
      for (std::size_t i = 0; i < nodes; ++i) mixture += weight[i] * part[i][k];
      if (mixture <= 0) continue;
      for (std::size_t i = 0; i < nodes; ++i) factor[i] += part[i][k] * target[k] / mixture;
    }
    for (std::size_t i = 0; i < nodes; ++i) weight[i] *= factor[i];
  }
  return weight;
}

// Integers that sum to 16 * 256, rounded from the tail inwards, so that the flanks are accurate.
std::array<int, columns> rounded(const std::vector<double>& weight) {
  std::array<int, columns> count{};
  constexpr int total = columns * resolution;
  double sum = double(tail_count) / total;
  int previous = tail_count;
  count[nodes] = tail_count;
  for (std::size_t i = nodes; i-- > 0;) {
    sum += weight[i];
    const int cumulative = i == 0 ? total : int(std::lround(total * sum));
    count[i] = cumulative - previous;
    previous = cumulative;
  }
  return count;
}

// Walker's alias method: the node with the smallest count shares its column with the one with the
// largest.
void fill_alias(std::array<int, columns> count, GaussianTables& tables) {
  for (std::size_t i = 0; i < columns; ++i) tables.alias[i] = static_cast<std::uint8_t>(i);
  std::array<bool, columns> done{};
  for (int turn = 0; turn < columns; ++turn) {
    std::size_t smallest = columns;
    std::size_t largest = 0;
    for (std::size_t i = 0; i < columns; ++i) {
      if (done[i]) continue;
      if (smallest == columns || count[i] < count[smallest]) smallest = i;
      if (done[largest] || count[i] > count[largest]) largest = i;
    }
    // A full column is its own alias: its threshold does not matter.
    done[smallest] = true;
    const int own = std::min(count[smallest], resolution - 1);
    tables.threshold[smallest] = static_cast<std::int8_t>(own - 128);
    if (count[smallest] >= resolution) continue;
    tables.alias[smallest] = static_cast<std::uint8_t>(largest);
    count[largest] -= resolution - count[smallest];
  }
}

}  // namespace

GaussianTables gaussian_tables(double deviation) {
  // Line segments of a third of a standard deviation approximate the bell curve well enough, and
  // segments twice as long its flanks.
  int spacing = 1;  // the power of two next below a third of the deviation, within limits
  for (int bits = 1; bits < maximum_mask_bits; ++bits) {
    if (2 * spacing <= deviation / 3) spacing *= 2;
  }
  GaussianTables tables{};
  int node = spacing / 2;
  for (int i = 0; i < nodes; ++i) {
    const int mask = (i < narrow_nodes ? 1 : 2) * spacing - 1;
    if (i > 0) node += i > narrow_nodes ? 2 * spacing : spacing;
    const bool is_beyond = node - mask >= maximum_step;
    tables.node[static_cast<std::size_t>(i)] =
        static_cast<std::uint8_t>(std::min(node, maximum_step));
    tables.mask[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(is_beyond ? 0 : mask);
  }
  tables.mask[nodes] = GaussianTables::tail_mark;
  std::vector<double> target = target_distribution(deviation);
  fill_tail(take_tail(target), tables);
  fill_alias(rounded(fitted_weights(tables, target)), tables);
  return tables;
}

UniformSteps uniform_steps(double half_width) {
  constexpr double maximum = 32767;  // of a signed 16-bit number
  int doublings = 0;
  for (; half_width > maximum - 1; half_width /= 2) ++doublings;
  int shift = 14;
  while (std::ldexp(half_width + 0.5, shift) > maximum) --shift;
  // Rounding = adding 1/2 and rounding down.
  const double unit = std::ldexp(1.0, shift);
  const double half = unit / 2;
  return {static_cast<std::uint16_t>(std::lround(2 * half_width * unit)),
          static_cast<std::int16_t>(std::lround(half - half_width * unit)), shift, doublings};
}

namespace {
constexpr double highest = 1e6;  // percent; at more, too, all but a few pixels are black or white
}

VisualNoise::VisualNoise(const Percent& percent) : percent_(percent) {
  for (const double level : percent) {
    checked(level, std::isfinite(level) && level >= 0, "percent must be at least 0 and finite");
  }
  const auto [gaussian, uniform] = percent;
  if (gaussian > 0 && uniform > 0) {
    throw std::invalid_argument("noise must be Gaussian or uniform, got both");
  }
  if (gaussian > 0) gaussian_ = gaussian_tables(2.55 * std::min(gaussian, highest));
  if (uniform > 0) uniform_ = uniform_steps(2.55 * std::min(uniform, highest));
}

void VisualNoise::add(const ImageView& clean, std::uint64_t seed, std::uint64_t index,
                      const WritableView& noisy) const {
  NoiseStream stream(seed, index);
  const int bytes = 3 * clean.width;
  for (int v = 0; v < clean.height; ++v) {
    if (is_off() && noisy.row(v) != clean.row(v)) std::copy_n(clean.row(v), bytes, noisy.row(v));
    if (gaussian_) add_gaussian(clean.row(v), bytes, *gaussian_, stream, noisy.row(v));
    if (uniform_) add_uniform(clean.row(v), bytes, *uniform_, stream, noisy.row(v));
  }
}

}  // namespace robsim
