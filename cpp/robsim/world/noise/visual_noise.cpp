#include "robsim/world/noise/visual_noise.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "robsim/base/system.hpp"
#include "robsim/world/noise/add_noise.hpp"

namespace robsim {

namespace {
constexpr double highest = 1e6;  // percent; at more, too, all but a few pixels are black or white
}

VisualNoise::VisualNoise(NoiseKind kind, double percent) : kind_(kind), percent_(percent) {
  if (!(std::isfinite(percent) && percent >= 0)) {
    throw std::invalid_argument("percent must be at least 0 and finite, got " + to_text(percent));
  }
  if (percent == 0) return;
  const double scale = 2.55 * std::min(percent, highest);
  if (kind == NoiseKind::gaussian) gaussian_ = gaussian_tables(scale);
  if (kind == NoiseKind::uniform) uniform_ = uniform_steps(scale);
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
