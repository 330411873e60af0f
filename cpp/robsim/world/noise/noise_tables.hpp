#pragma once

#include <array>
#include <cstdint>

namespace robsim {

/// Tables to draw integer-valued Gaussian noise from 24 random bits:
///
///     step = +- (node + u1 - u2),  u1, u2 uniform on 0..mask
///
/// u1 - u2 has a triangular distribution, so that the mixture over the nodes is a density that is
/// linear from node to node. One of 16 nodes is drawn by Walker's alias method, which picks a
/// column of a table uniformly, and then its own node or its alias.
struct GaussianTables {
  std::array<std::int8_t, 16> threshold;  // of a random signed byte; below: own node
  std::array<std::uint8_t, 16> alias;     // the other node of the column
  std::array<std::uint8_t, 16> node;      // 0..255
  std::array<std::uint8_t, 16> mask;      // 2^k - 1, at most 31
};

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

}  // namespace robsim
