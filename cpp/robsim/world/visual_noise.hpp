#pragma once

#include <cstdint>
#include <vector>

#include "robsim/imaging/image.hpp"

namespace robsim {

enum class NoiseKind { none, uniform, gaussian };

/// Noise of the camera: independent per pixel and channel, added, rounded, clipped to 0..255.
/// At p percent it is uniform within +-2.55 p or Gaussian with sigma = 2.55 p.
class VisualNoise {
 public:
  /// Throws std::invalid_argument for a level below 0 or not finite.
  explicit VisualNoise(NoiseKind kind = NoiseKind::none, double percent = 0);

  bool is_off() const { return steps_.empty(); }

  /// Writes clean + noise to `noisy`, which has the same size. The noise of frame `index` depends
  /// on the seed and on the index alone.
  void add(const ImageView& clean, std::uint64_t seed, std::uint64_t index, Image& noisy) const;

 private:
  // A pixel is a whole number, so that rounding its sum with the noise is adding a whole number:
  // the noise is drawn from the probabilities of the steps -255..255 by Walker's alias method.
  struct Step {
    std::uint32_t threshold;  // of 2^23
    std::int16_t values[2];   // below the threshold, and from it on
  };

  std::uint8_t noisy_value(std::uint8_t value, std::uint32_t draw) const;

  std::vector<Step> steps_;
};

}  // namespace robsim
