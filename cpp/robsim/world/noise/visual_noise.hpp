#pragma once

#include <cstdint>
#include <optional>

#include "robsim/imaging/image.hpp"
#include "robsim/world/noise/noise_tables.hpp"

namespace robsim {

enum class NoiseKind { none, uniform, gaussian };

/// Noise of the camera: independent per pixel and channel, added, rounded, clipped to 0..255.
/// At p percent it is uniform within +-2.55 p or Gaussian with sigma = 2.55 p.
class VisualNoise {
 public:
  /// Throws std::invalid_argument for a level below 0 or not finite.
  explicit VisualNoise(NoiseKind kind = NoiseKind::none, double percent = 0);

  bool is_off() const { return !gaussian_ && !uniform_; }
  NoiseKind kind() const { return kind_; }
  double percent() const { return percent_; }

  /// Writes clean + noise to `noisy`, which has the same size and may be the same pixels. The noise
  /// of frame `index` depends on the seed and on the index alone.
  void add(const ImageView& clean, std::uint64_t seed, std::uint64_t index,
           const WritableView& noisy) const;

 private:
  NoiseKind kind_;
  double percent_;
  // A pixel is a whole number, so that rounding its sum with the noise is adding a whole number.
  std::optional<GaussianTables> gaussian_;
  std::optional<UniformSteps> uniform_;
};

}  // namespace robsim
