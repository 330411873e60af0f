#include "robsim/world/visual_noise.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "robsim/random/counter_random.hpp"

namespace robsim {

namespace {

constexpr int largest = 255;        // a larger step clips as this one does
constexpr int places = 512;         // of the alias table, a power of two above 2 * 255 + 1
constexpr int threshold_bits = 23;  // 9 bits of a 32-bit number choose the place

double distribution(NoiseKind kind, double scale, double x) {
  if (kind == NoiseKind::uniform) return std::clamp(0.5 + x / (2 * scale), 0.0, 1.0);
  return 0.5 * std::erfc(-x / (scale * std::sqrt(2.0)));
}

// P(step k) = F(k + 1/2) - F(k - 1/2), the tails at the ends
std::vector<double> step_probabilities(NoiseKind kind, double scale) {
  std::vector<double> probability(places, 0.0);
  double below = 0;
  for (int k = -largest; k <= largest; ++k) {
    const double up_to = k == largest ? 1.0 : distribution(kind, scale, k + 0.5);
    probability[static_cast<std::size_t>(k + largest)] = up_to - below;
    below = up_to;
  }
  return probability;
}

}  // namespace

VisualNoise::VisualNoise(NoiseKind kind, double percent) {
  if (!(std::isfinite(percent) && percent >= 0)) {
    throw std::invalid_argument("percent must be at least 0 and finite, got " +
                                std::to_string(percent));
  }
  if (kind == NoiseKind::none || percent == 0) return;
  std::vector<double> share = step_probabilities(kind, 2.55 * percent);
  std::vector<std::size_t> small, large;
  for (std::size_t i = 0; i < places; ++i) {
    share[i] *= places;
    (share[i] < 1 ? small : large).push_back(i);
  }
  // Walker's alias method: each place holds its own step and fills up with that of one other.
  const auto value = [](std::size_t i) { return static_cast<std::int16_t>(int(i) - largest); };
  constexpr double full = 1U << threshold_bits;
  steps_.resize(places);
  while (!small.empty() && !large.empty()) {
    const std::size_t i = small.back();
    const std::size_t j = large.back();
    small.pop_back();
    steps_[i] = {static_cast<std::uint32_t>(std::lround(share[i] * full)), {value(i), value(j)}};
    share[j] -= 1 - share[i];
    if (share[j] < 1) {
      large.pop_back();
      small.push_back(j);
    }
  }
  for (const auto* rest : {&small, &large}) {
    for (const std::size_t i : *rest) steps_[i] = {1U << threshold_bits, {value(i), value(i)}};
  }
}

std::uint8_t VisualNoise::noisy_value(std::uint8_t value, std::uint32_t draw) const {
  const Step& step = steps_[draw >> threshold_bits];
  const bool own = (draw & ((1U << threshold_bits) - 1)) < step.threshold;
  return static_cast<std::uint8_t>(std::clamp(value + step.values[own ? 0 : 1], 0, largest));
}

void VisualNoise::add(const ImageView& clean, std::uint64_t seed, std::uint64_t index,
                      Image& noisy) const {
  Xoshiro256 random(seed, index);
  for (int v = 0; v < clean.height; ++v) {
    const std::uint8_t* from = clean.row(v);
    std::uint8_t* to = noisy.row(v);
    const int count = 3 * clean.width;
    int i = 0;
    for (; i + 1 < count; i += 2) {
      const std::uint64_t bits = random.next();
      to[i] = noisy_value(from[i], static_cast<std::uint32_t>(bits));
      to[i + 1] = noisy_value(from[i + 1], static_cast<std::uint32_t>(bits >> 32));
    }
    if (i < count) to[i] = noisy_value(from[i], static_cast<std::uint32_t>(random.next()));
  }
}

}  // namespace robsim
