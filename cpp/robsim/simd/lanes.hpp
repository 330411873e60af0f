#pragma once

#include <cstring>
#include <functional>

#include "robsim/simd/target.hpp"

namespace robsim::simd {

/// A vector of four doubles, in registers as wide as the processor has. In memory: four doubles of
/// any alignment.
class Lanes {
 public:
  static constexpr int count = 4;

  ROBSIM_INLINE Lanes(double a, double b, double c, double d) : vector_{a, b, c, d} {}
  static ROBSIM_INLINE Lanes all(double value) { return {value, value, value, value}; }

  static ROBSIM_INLINE Lanes load(const double* values) {
    Vector vector;
    std::memcpy(&vector, values, sizeof(vector));
    return Lanes(vector);
  }
  ROBSIM_INLINE void store(double* values) const { std::memcpy(values, &vector_, sizeof(vector_)); }

  friend ROBSIM_INLINE Lanes operator+(const Lanes& a, const Lanes& b) {
    return Lanes(a.vector_ + b.vector_);
  }
  friend ROBSIM_INLINE Lanes operator-(const Lanes& a, const Lanes& b) {
    return Lanes(a.vector_ - b.vector_);
  }
  friend ROBSIM_INLINE Lanes operator*(const Lanes& a, const Lanes& b) {
    return Lanes(a.vector_ * b.vector_);
  }
  friend ROBSIM_INLINE Lanes operator/(const Lanes& a, const Lanes& b) {
    return Lanes(a.vector_ / b.vector_);
  }

 private:
#if defined(__GNUC__) || defined(__clang__)
  using Vector = double __attribute__((vector_size(count * sizeof(double))));
#else
  struct Vector {
    double at[count];

    template <typename Operation>
    Vector with(const Vector& other, Operation operation) const {
      Vector result;
      for (int i = 0; i < count; ++i) result.at[i] = operation(at[i], other.at[i]);
      return result;
    }
    Vector operator+(const Vector& other) const { return with(other, std::plus<>()); }
    Vector operator-(const Vector& other) const { return with(other, std::minus<>()); }
    Vector operator*(const Vector& other) const { return with(other, std::multiplies<>()); }
    Vector operator/(const Vector& other) const { return with(other, std::divides<>()); }
  };
#endif

  explicit ROBSIM_INLINE Lanes(const Vector& vector) : vector_(vector) {}

  Vector vector_;
};

}  // namespace robsim::simd
