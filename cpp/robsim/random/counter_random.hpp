#pragma once

#include <cstdint>

namespace robsim {

/// The random number at place `counter` of the stream `seed`: a pure function, so that what is
/// drawn for one step or one frame does not depend on what was drawn before.
/// Method: SplitMix64 (Steele, Lea and Flood 2014), used as a hash of seed and counter.
std::uint64_t random_bits(std::uint64_t seed, std::uint64_t counter);

/// The same as a number in [0, 1) with 53 random bits.
double random_uniform(std::uint64_t seed, std::uint64_t counter);

/// A fast sequential generator: xoshiro256++ 1.0 (Blackman and Vigna 2019).
class Xoshiro256 {
 public:
  /// Starts at a place that depends on the stream and on the counter (frame, block, ...).
  Xoshiro256(std::uint64_t seed, std::uint64_t counter);

  std::uint64_t next() {
    const std::uint64_t result = rotate(state_[0] + state_[3], 23) + state_[0];
    const std::uint64_t shifted = state_[1] << 17;
    state_[2] ^= state_[0];
    state_[3] ^= state_[1];
    state_[1] ^= state_[2];
    state_[0] ^= state_[3];
    state_[2] ^= shifted;
    state_[3] = rotate(state_[3], 45);
    return result;
  }

 private:
  static std::uint64_t rotate(std::uint64_t bits, int count) {
    return (bits << count) | (bits >> (64 - count));
  }

  std::uint64_t state_[4];
};

}  // namespace robsim
