#include "robsim/base/random/counter_random.hpp"

#include <cmath>

#include "robsim/base/elementary/exponential.hpp"
#include "robsim/base/elementary/sine.hpp"

namespace robsim {

namespace {

constexpr std::uint64_t golden = 0x9E3779B97F4A7C15ULL;

std::uint64_t mix(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
  return z ^ (z >> 31);
}

}  // namespace

std::uint64_t random_bits(std::uint64_t seed, std::uint64_t counter) {
  // The seed is mixed first: otherwise neighbouring seeds give shifted copies of one stream.
  return mix(mix(seed + golden) + (counter + 1) * golden);
}

double random_uniform(std::uint64_t seed, std::uint64_t counter) {
  return static_cast<double>(random_bits(seed, counter) >> 11) * 0x1.0p-53;
}

double random_normal(std::uint64_t seed, std::uint64_t counter) {
  constexpr double two_pi = 6.283185307179586;
  // sqrt(-2 ln a) cos(2 pi b), a in (0, 1], b in [0, 1): Box and Muller 1958
  const double a = 1 - random_uniform(seed, 2 * counter);
  const double b = random_uniform(seed, 2 * counter + 1);
  return std::sqrt(-2 * elementary::log(a)) * elementary::cos(two_pi * b);
}

}  // namespace robsim
