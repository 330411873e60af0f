#pragma once

#include <cstdint>

namespace robsim {

/// The random number at position `counter` of the stream `seed`: a pure function, so that the draws
/// of one step or frame do not depend on earlier ones.
/// Method: SplitMix64 (Steele, Lea and Flood 2014), used as a hash of seed and counter.
std::uint64_t random_bits(std::uint64_t seed, std::uint64_t counter);

/// The same as a number in [0, 1) with 53 random bits.
double random_uniform(std::uint64_t seed, std::uint64_t counter);

/// A number of the standard normal distribution, from the positions 2 counter and 2 counter + 1.
double random_normal(std::uint64_t seed, std::uint64_t counter);

}  // namespace robsim
