#pragma once

#include <cstring>
#include <functional>

#include "robsim/simd/cpu_path.hpp"

// Before a loop over a few lanes whose number the compiler knows.
#if defined(__clang__)
#define ROBSIM_UNROLL _Pragma("unroll")
#elif defined(__GNUC__)
#define ROBSIM_UNROLL _Pragma("GCC unroll 8")
#else
#define ROBSIM_UNROLL
#endif

namespace robsim {

/// Four numbers side by side, in the wide registers of a processor. In memory they are four
/// doubles, aligned as any.
class Lanes {
 public:
  static constexpr int count = 4;

  ROBSIM_INLINE Lanes(double a, double b, double c, double d) : wide_{a, b, c, d} {}
  static ROBSIM_INLINE Lanes all(double value) { return {value, value, value, value}; }

  static ROBSIM_INLINE Lanes load(const double* values) {
    Wide wide;
    std::memcpy(&wide, values, sizeof(wide));
    return Lanes(wide);
  }
  ROBSIM_INLINE void store(double* values) const { std::memcpy(values, &wide_, sizeof(wide_)); }

  friend ROBSIM_INLINE Lanes operator+(const Lanes& a, const Lanes& b) {
    return Lanes(a.wide_ + b.wide_);
  }
  friend ROBSIM_INLINE Lanes operator-(const Lanes& a, const Lanes& b) {
    return Lanes(a.wide_ - b.wide_);
  }
  friend ROBSIM_INLINE Lanes operator*(const Lanes& a, const Lanes& b) {
    return Lanes(a.wide_ * b.wide_);
  }
  friend ROBSIM_INLINE Lanes operator/(const Lanes& a, const Lanes& b) {
    return Lanes(a.wide_ / b.wide_);
  }

 private:
#if defined(__GNUC__) || defined(__clang__)
  using Wide = double __attribute__((vector_size(count * sizeof(double))));
#else
  struct Wide {
    double at[count];

    template <typename Operation>
    Wide with(const Wide& other, Operation operation) const {
      Wide result;
      for (int i = 0; i < count; ++i) result.at[i] = operation(at[i], other.at[i]);
      return result;
    }
    Wide operator+(const Wide& other) const { return with(other, std::plus<>()); }
    Wide operator-(const Wide& other) const { return with(other, std::minus<>()); }
    Wide operator*(const Wide& other) const { return with(other, std::multiplies<>()); }
    Wide operator/(const Wide& other) const { return with(other, std::divides<>()); }
  };
#endif

  explicit ROBSIM_INLINE Lanes(const Wide& wide) : wide_(wide) {}

  Wide wide_;
};

}  // namespace robsim
