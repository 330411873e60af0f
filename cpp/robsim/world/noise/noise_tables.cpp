#include "robsim/world/noise/noise_tables.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace robsim {

namespace {

constexpr int largest = 255;  // a larger step clips as this one does
constexpr int nodes = 16;     // on each side of 0
constexpr int narrow_nodes = 10;
constexpr int bits_of_mask = 5;  // at most
constexpr int resolution = 256;  // of the share of a place
constexpr int rounds = 200;      // of the fit

// P(|step| = k) for k = 0..255, the tail at the end
std::vector<double> wanted(double deviation) {
  std::vector<double> probability(largest + 1);
  double outside = 1;
  for (int k = 0; k <= largest; ++k) {
    const double next = k == largest ? 0 : std::erfc((k + 0.5) / (deviation * std::sqrt(2.0)));
    probability[static_cast<std::size_t>(k)] = outside - next;
    outside = next;
  }
  return probability;
}

// What one node gives: P(|step| = k)
std::vector<double> given_by(int node, int mask) {
  std::vector<double> probability(largest + 1, 0.0);
  const int count = mask + 1;
  for (int difference = -mask; difference <= mask; ++difference) {
    const double share = double(count - std::abs(difference)) / (double(count) * count);
    const int step = std::min(std::abs(node + difference), largest);
    probability[static_cast<std::size_t>(step)] += share;
  }
  return probability;
}

// The shares of the nodes whose mixture is nearest to what is wanted.
// Method: expectation-maximisation for the shares of a mixture (Dempster, Laird and Rubin 1977).
std::vector<double> fitted_shares(const GaussianTables& tables, double deviation) {
  const std::vector<double> target = wanted(deviation);
  std::vector<std::vector<double>> part;
  for (std::size_t i = 0; i < nodes; ++i) {
    part.push_back(given_by(tables.node[i], tables.mask[i]));
  }
  std::vector<double> share(nodes, 1.0 / nodes);
  for (int round = 0; round < rounds; ++round) {
    std::vector<double> factor(nodes, 0.0);
    for (std::size_t k = 0; k <= largest; ++k) {
      double mixture = 0;
      for (std::size_t i = 0; i < nodes; ++i) mixture += share[i] * part[i][k];
      if (mixture <= 0) continue;
      for (std::size_t i = 0; i < nodes; ++i) factor[i] += part[i][k] * target[k] / mixture;
    }
    for (std::size_t i = 0; i < nodes; ++i) share[i] *= factor[i];
  }
  return share;
}

// Whole numbers that sum up to 16 * 256; rounded from the tail inwards, so that the tail is right.
std::array<int, nodes> rounded(const std::vector<double>& share) {
  std::array<int, nodes> count{};
  double sum = 0;
  int before = 0;
  for (std::size_t i = nodes; i-- > 0;) {
    sum += share[i];
    const int up_to = i == 0 ? nodes * resolution : int(std::lround(nodes * resolution * sum));
    count[i] = up_to - before;
    before = up_to;
  }
  return count;
}

void fill_alias(std::array<int, nodes> count, GaussianTables& tables) {
  for (std::size_t i = 0; i < nodes; ++i) tables.alias[i] = static_cast<std::uint8_t>(i);
  std::array<bool, nodes> done{};
  for (int turn = 0; turn < nodes; ++turn) {
    std::size_t least = nodes;
    std::size_t most = 0;
    for (std::size_t i = 0; i < nodes; ++i) {
      if (done[i]) continue;
      if (least == nodes || count[i] < count[least]) least = i;
      if (done[most] || count[i] > count[most]) most = i;
    }
    // A full place is its own alias: its threshold does not matter.
    done[least] = true;
    const int own = std::min(count[least], resolution - 1);
    tables.threshold[least] = static_cast<std::int8_t>(own - 128);
    if (count[least] >= resolution) continue;
    tables.alias[least] = static_cast<std::uint8_t>(most);
    count[most] -= resolution - count[least];
  }
}

}  // namespace

GaussianTables gaussian_tables(double deviation) {
  // Straight lines a third of a deviation long are near enough to a bell curve, and twice as long
  // ones to its flanks.
  const int bits = static_cast<int>(std::floor(std::log2(std::max(deviation / 3, 1.0))));
  const int spacing = 1 << std::min(bits, bits_of_mask - 1);
  GaussianTables tables{};
  int node = spacing / 2;
  for (int i = 0; i < nodes; ++i) {
    const int mask = (i < narrow_nodes ? 1 : 2) * spacing - 1;
    if (i > 0) node += i > narrow_nodes ? 2 * spacing : spacing;
    const bool is_beyond = node - mask >= largest;
    tables.node[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(std::min(node, largest));
    tables.mask[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(is_beyond ? 0 : mask);
  }
  fill_alias(rounded(fitted_shares(tables, deviation)), tables);
  return tables;
}

UniformSteps uniform_steps(double reach) {
  constexpr double most = 32767;  // of a 16-bit number
  int doublings = 0;
  for (; reach > most - 1; reach /= 2) ++doublings;
  int shift = 14;
  while (std::ldexp(reach + 0.5, shift) > most) --shift;
  // Rounding is adding a half and rounding down.
  const double unit = std::ldexp(1.0, shift);
  const double half = unit / 2;
  return {static_cast<std::uint16_t>(std::lround(2 * reach * unit)),
          static_cast<std::int16_t>(std::lround(half - reach * unit)), shift, doublings};
}

}  // namespace robsim
