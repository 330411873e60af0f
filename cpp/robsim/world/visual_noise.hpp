#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "robsim/imaging/image.hpp"

namespace robsim {

/// Tables to draw integer-valued Gaussian noise from 24 random bits:
///
///     step = +- (node + u1 - u2),  u1, u2 uniform on 0..mask
///
/// u1 - u2 has a triangular distribution, so that the mixture over the nodes is a density that is
/// linear from node to node. One of 16 nodes is drawn by Walker's alias method, which picks a
/// column of a table uniformly, and then its own node or its alias.
///
/// Nodes come in shares of 1/4096: too coarse for what lies beyond 3.7 standard deviations. The
/// last node, of one share, stands for all of that tail, whose step is drawn by 33 bits more.
struct GaussianTables {
  static constexpr std::uint8_t tail_mark = 128;  // bit of the mask of the last node

  std::array<std::int8_t, 16> threshold;  // of a random signed byte; below: own node
  std::array<std::uint8_t, 16> alias;     // the other node of the column
  std::array<std::uint8_t, 16> node;      // 0..255
  std::array<std::uint8_t, 16> mask;      // 2^k - 1, at most 31, or tail_mark
  int tail_first;                         // the smallest |step| of the tail
  std::array<std::uint32_t, 256> beyond;  // P(|step| > k) in the tail, in units of 2^-32
};

/// The step of the tail for 64 random bits.
inline int tail_step(std::uint64_t bits, const GaussianTables& tables) {
  const auto drawn = static_cast<std::uint32_t>(bits);
  int step = tables.tail_first;
  while (drawn < tables.beyond[static_cast<std::size_t>(step)]) ++step;
  return (bits >> 63) != 0 ? -step : step;
}

/// The tables for a positive standard deviation. The steps are clipped to -255..255.
GaussianTables gaussian_tables(double deviation);

/// Numbers to draw uniform noise: step = (high 16 bits of (16 random bits * scale) + offset) >>
/// shift, then doubled `doublings` times.
struct UniformSteps {
  std::uint16_t scale;
  std::int16_t offset;
  int shift;
  int doublings;  // 0 unless the half-width exceeds 16 bits
};

/// Uniform within +- half_width, rounded.
UniformSteps uniform_steps(double half_width);

/// Noise of the camera: independent per pixel and channel, added, rounded, clipped to 0..255.
/// At p percent it is uniform within +-2.55 p or Gaussian with sigma = 2.55 p.
class VisualNoise {
 public:
  using Percent = std::array<double, 2>;  // Gaussian, uniform: one of them is 0

  /// Throws std::invalid_argument for a level below 0 or not finite, and for two.
  explicit VisualNoise(const Percent& percent = {});

  bool is_off() const { return !gaussian_ && !uniform_; }
  const Percent& percent() const { return percent_; }

  /// Writes clean + noise to `noisy`, which has the same size and may be the same pixels. The noise
  /// of frame `index` depends on the seed and on the index alone.
  void add(const ImageView& clean, std::uint64_t seed, std::uint64_t index,
           const WritableView& noisy) const;

 private:
  Percent percent_;
  // A pixel is a whole number, so that rounding its sum with the noise is adding a whole number.
  std::optional<GaussianTables> gaussian_;
  std::optional<UniformSteps> uniform_;
};

}  // namespace robsim
