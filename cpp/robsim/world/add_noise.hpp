#pragma once

#include <cstdint>

#include "robsim/world/visual_noise.hpp"

namespace robsim {

/// The random bits of one frame: three streams of 32 bytes per draw, each of four interleaved
/// generators. Generator: xoshiro256+ 1.0 (Blackman and Vigna 2019).
struct NoiseStream {
  static constexpr int streams = 3;
  static constexpr int lanes = 4;

  NoiseStream(std::uint64_t seed, std::uint64_t index);

  /// The bits of the rare draws of byte i of the row that comes next.
  std::uint64_t rare_bits(int i) const;

  alignas(32) std::uint64_t state[streams][4][lanes];
  std::uint64_t rare_key;
  std::uint64_t bytes_done = 0;  // of all rows so far
};

/// Writes clean + noise, clipped to 0..255. Every 32 bytes of a row use one draw of each stream.
void add_gaussian(const std::uint8_t* clean, int bytes, const GaussianTables& tables,
                  NoiseStream& stream, std::uint8_t* noisy);

void add_uniform(const std::uint8_t* clean, int bytes, const UniformSteps& steps,
                 NoiseStream& stream, std::uint8_t* noisy);

}  // namespace robsim
