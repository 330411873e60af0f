#include "robsim/base/elementary/reduced_angle.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace robsim::elementary {

namespace {

struct Magnitude {
  std::uint64_t mantissa;  // an integer of 53 bits
  int exponent;            // of 2, by which it is multiplied
};

Magnitude magnitude_of(double x) {
  std::uint64_t bits;
  std::memcpy(&bits, &x, sizeof bits);
  const auto exponent = static_cast<int>((bits >> 52) & 0x7FF);
  constexpr std::uint64_t leading = std::uint64_t{1} << 52;
  return {(bits & (leading - 1)) | leading, exponent - 1075};
}

constexpr int window_words = 7;  // of 32 bits

using Window = std::array<std::uint32_t, window_words>;

// The 32 binary digits of 2/pi that begin `position` places behind the point.
std::uint32_t digits_at(int position) {
  constexpr int places_before_the_point = 64;
  const int word = (position + places_before_the_point) / 32;
  const int shift = (position + places_before_the_point) % 32;
  const std::uint64_t both =
      (std::uint64_t{two_over_pi_words[word]} << 32) | two_over_pi_words[word + 1];
  return static_cast<std::uint32_t>(both >> (32 - shift));
}

// The quadrants mantissa 2^exponent 2/pi modulo 4: two bits before the binary point, the others
// behind it. Digits of 2/pi that give multiples of 4 are left out; those beyond the window change
// the result by less than 2^-168.
Window quadrants(const Magnitude& x) {
  Window digits;
  for (int i = 0; i < window_words; ++i) digits[i] = digits_at(x.exponent - 2 + 32 * i);
  Window product{};
  std::uint64_t carry = 0;
  for (int i = window_words - 1; i >= 0; --i) {
    const std::uint64_t low = (x.mantissa & 0xFFFFFFFF) * digits[i] + carry;
    product[i] = static_cast<std::uint32_t>(low);
    carry = low >> 32;
  }
  carry = 0;
  for (int i = window_words - 2; i >= 0; --i) {
    const std::uint64_t high = (x.mantissa >> 32) * digits[i + 1] + product[i] + carry;
    product[i] = static_cast<std::uint32_t>(high);
    carry = high >> 32;
  }
  return product;
}

// The value of a window times pi/2.
DoubleDouble angle_of(const Window& window) {
  DoubleDouble q;
  double unit = 0x1.0p-30;  // of the first word
  for (const std::uint32_t word : window) {
    const DoubleDouble sum = exact_sum(q.high, word * unit);
    q = exact_sum(sum.high, sum.low + q.low);
    unit *= 0x1.0p-32;
  }
  const DoubleDouble angle = exact_product(q.high, pi_2[0]);
  return exact_sum(angle.high, angle.low + (q.high * pi_2[1] + q.low * pi_2[0]));
}

}  // namespace

ReducedAngle reduced_by_digits(double angle) {
  constexpr std::uint32_t half_a_quadrant = 1U << 29;
  Window window = quadrants(magnitude_of(angle));
  const std::uint32_t nearest = (window[0] + half_a_quadrant) >> 30;
  const bool is_below = (window[0] & half_a_quadrant) != 0;  // the nearest multiple is the next one
  if (is_below) {
    for (std::uint32_t& word : window) word = ~word;  // -1 - x
  }
  window[0] &= 2 * half_a_quadrant - 1;
  const DoubleDouble rest = angle_of(window);
  const bool is_turned = is_below != std::signbit(angle);
  const int quadrant = static_cast<int>(nearest & 3);
  return {is_turned ? DoubleDouble{-rest.high, -rest.low} : rest,
          std::signbit(angle) ? -quadrant & 3 : quadrant};
}

}  // namespace robsim::elementary
