#pragma once

#include <cstring>
#include <functional>
#include <type_traits>

#include "robsim/base/simd/target.hpp"

namespace robsim::simd {

/// A vector of so many bytes of numbers. In memory: so many numbers at any alignment. Operations
/// are those of the numbers, one by one.
template <typename Number, int bytes = 32>
class LanesOf {
 public:
  using Element = Number;
  static constexpr int count = bytes / sizeof(Number);

  LanesOf() = default;  // any numbers

  /// So many numbers as there are lanes.
  template <typename... Numbers, typename = std::enable_if_t<sizeof...(Numbers) == count>>
  ROBSIM_INLINE LanesOf(Numbers... numbers) : vector_{static_cast<Number>(numbers)...} {}

  static ROBSIM_INLINE LanesOf all(Number value) { return LanesOf(value - Vector{}); }

  static ROBSIM_INLINE LanesOf load(const Number* values) {
    Vector vector;
    std::memcpy(&vector, values, sizeof(vector));
    return LanesOf(vector);
  }
  ROBSIM_INLINE void store(Number* values) const { std::memcpy(values, &vector_, sizeof(vector_)); }

  ROBSIM_INLINE Number at(int i) const {
    Number numbers[count];
    store(numbers);
    return numbers[i];
  }

  friend ROBSIM_INLINE LanesOf operator+(const LanesOf& a, const LanesOf& b) {
    return LanesOf(a.vector_ + b.vector_);
  }
  friend ROBSIM_INLINE LanesOf operator-(const LanesOf& a, const LanesOf& b) {
    return LanesOf(a.vector_ - b.vector_);
  }
  friend ROBSIM_INLINE LanesOf operator*(const LanesOf& a, const LanesOf& b) {
    return LanesOf(a.vector_ * b.vector_);
  }
  friend ROBSIM_INLINE LanesOf operator/(const LanesOf& a, const LanesOf& b) {
    return LanesOf(a.vector_ / b.vector_);
  }

  /// The numbers of `a`, moved into [least, most].
  friend ROBSIM_INLINE LanesOf within(const LanesOf& a, const LanesOf& least, const LanesOf& most) {
#if defined(__GNUC__) || defined(__clang__)
    const Vector raised = a.vector_ > least.vector_ ? a.vector_ : least.vector_;
    return LanesOf(raised < most.vector_ ? raised : most.vector_);
#else
    const Vector raised =
        a.vector_.with(least.vector_, [](Number x, Number y) { return x > y ? x : y; });
    return LanesOf(raised.with(most.vector_, [](Number x, Number y) { return x < y ? x : y; }));
#endif
  }

 private:
#if defined(__GNUC__) || defined(__clang__)
  typedef Number Vector __attribute__((vector_size(bytes)));  // `using` would lose the attribute
#else
  struct Vector {
    Number at[count];

    template <typename Operation>
    Vector with(const Vector& other, Operation operation) const {
      Vector result;
      for (int i = 0; i < count; ++i) result.at[i] = operation(at[i], other.at[i]);
      return result;
    }
    friend Vector operator-(Number value, const Vector& other) {
      Vector result;
      for (int i = 0; i < count; ++i) result.at[i] = value - other.at[i];
      return result;
    }
    Vector operator+(const Vector& other) const { return with(other, std::plus<>()); }
    Vector operator-(const Vector& other) const { return with(other, std::minus<>()); }
    Vector operator*(const Vector& other) const { return with(other, std::multiplies<>()); }
    Vector operator/(const Vector& other) const { return with(other, std::divides<>()); }
  };
#endif

  explicit ROBSIM_INLINE LanesOf(const Vector& vector) : vector_(vector) {}

  Vector vector_;
};

using Lanes = LanesOf<double>;

/// The same 32 bytes in two vectors, for code that runs on any processor: compilers take wider
/// vectors than its own apart number by number where these are compared.
template <typename Number>
class HalvedLanesOf {
 public:
  using Half = LanesOf<Number, 16>;
  using Element = Number;
  static constexpr int count = 2 * Half::count;

  HalvedLanesOf() = default;  // any numbers

  static ROBSIM_INLINE HalvedLanesOf all(Number value) {
    return {Half::all(value), Half::all(value)};
  }

  static ROBSIM_INLINE HalvedLanesOf load(const Number* values) {
    return {Half::load(values), Half::load(values + Half::count)};
  }
  ROBSIM_INLINE void store(Number* values) const {
    low_.store(values);
    high_.store(values + Half::count);
  }

  friend ROBSIM_INLINE HalvedLanesOf operator+(const HalvedLanesOf& a, const HalvedLanesOf& b) {
    return {a.low_ + b.low_, a.high_ + b.high_};
  }
  friend ROBSIM_INLINE HalvedLanesOf operator-(const HalvedLanesOf& a, const HalvedLanesOf& b) {
    return {a.low_ - b.low_, a.high_ - b.high_};
  }
  friend ROBSIM_INLINE HalvedLanesOf operator*(const HalvedLanesOf& a, const HalvedLanesOf& b) {
    return {a.low_ * b.low_, a.high_ * b.high_};
  }

  friend ROBSIM_INLINE HalvedLanesOf within(const HalvedLanesOf& a, const HalvedLanesOf& least,
                                            const HalvedLanesOf& most) {
    return {within(a.low_, least.low_, most.low_), within(a.high_, least.high_, most.high_)};
  }

 private:
  ROBSIM_INLINE HalvedLanesOf(const Half& low, const Half& high) : low_(low), high_(high) {}

  Half low_, high_;
};

/// The sum of all numbers, always in the same order.
template <typename AnyLanes>
ROBSIM_INLINE double sum_of(const AnyLanes& lanes) {
  using Number = typename AnyLanes::Element;
  Number numbers[AnyLanes::count];
  lanes.store(numbers);
  double sum = 0;
  for (const Number number : numbers) sum += static_cast<double>(number);
  return sum;
}

}  // namespace robsim::simd
