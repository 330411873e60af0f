#pragma once

#include <array>
#include <cstdint>

namespace robsim {

/// How Gaussian noise of a whole number of steps is drawn from 24 random bits:
///
///     step = +- (node + u1 - u2),  u1, u2 uniform on 0..mask
///
/// u1 - u2 is distributed like a triangle, so that their sum over the nodes is the density drawn as
/// straight lines from node to node. The node is one of 16, drawn by Walker's alias method.
struct GaussianTables {
  std::array<std::int8_t, 16> threshold;  // of a random signed byte: below it the place's own node
  std::array<std::uint8_t, 16> alias;     // the other node of the place
  std::array<std::uint8_t, 16> node;      // 0..255
  std::array<std::uint8_t, 16> mask;      // 2^k - 1, at most 31
};

/// The tables for a standard deviation above 0. The steps are clipped to -255..255.
GaussianTables gaussian_tables(double deviation);

/// How uniform noise is drawn: step = (high 16 bits of (16 random bits * scale) + offset) >> shift,
/// doubled so often.
struct UniformSteps {
  std::uint16_t scale;
  std::int16_t offset;
  int shift;
  int doublings;  // 0 unless the reach is beyond 16 bits
};

/// Uniform within +- reach, rounded.
UniformSteps uniform_steps(double reach);

}  // namespace robsim
