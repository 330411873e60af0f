// Elementary functions against those of long double, which have 11 bits more; at values that those
// of the C standard (annex F) fix; and at angles for which the digits of pi count.
#include <gtest/gtest.h>

#include <cfloat>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>

#include "robsim/base/elementary/elementary.hpp"
#include "robsim/base/geometry.hpp"

namespace robsim {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr int draws = 100'000;  // a million were tried

// The error in units in the last place of what is right.
double error_of(double value, long double right) {
  const auto nearest = static_cast<double>(right);
  if (std::isnan(value) || std::isinf(nearest)) return value == nearest ? 0 : infinity;
  int exponent;
  std::frexp(nearest, &exponent);
  const double unit = std::ldexp(1.0, std::max(exponent - DBL_MANT_DIG, -1074));
  return static_cast<double>(std::fabs((value - right) / unit));
}

// Numbers from low to high; of all sizes and both signs.
double uniform(int i, double low, double high) {
  return low + (high - low) * random_uniform(1, static_cast<std::uint64_t>(i));
}

double of_any_size(int i) {
  for (std::uint64_t seed = 2;; ++seed) {
    const std::uint64_t bits = random_bits(seed, static_cast<std::uint64_t>(i));
    double value;
    std::memcpy(&value, &bits, sizeof value);
    if (std::isfinite(value)) return value;
  }
}

using Draw = std::function<double(int)>;

double worst(const Draw& draw, double (*function)(double), long double (*right)(long double)) {
  double most = 0;
  for (int i = 0; i < draws; ++i) {
    const double x = draw(i);
    most = std::max(most, error_of(function(x), right(x)));
  }
  return most;
}

double worst_of_two(const Draw& draw, double (*function)(double, double),
                    long double (*right)(long double, long double)) {
  double most = 0;
  for (int i = 0; i < draws; ++i) {
    const double a = draw(2 * i);
    const double b = draw(2 * i + 1);
    most = std::max(most, error_of(function(a, b), right(a, b)));
  }
  return most;
}

void expect_same(double value, double expected) {
  const bool is_same = value == expected && std::signbit(value) == std::signbit(expected);
  EXPECT_TRUE(is_same || (std::isnan(value) && std::isnan(expected)))
      << value << " for " << expected;
}

class Elementary : public testing::Test {
 protected:
  void SetUp() override {
    if (LDBL_MANT_DIG < 64) GTEST_SKIP() << "long double is not longer than double";
  }
};

TEST_F(Elementary, SinesErrByLessThanAUnitInTheLastPlace) {
  const Draw ranges[] = {[](int i) { return uniform(i, -4, 4); },
                         [](int i) { return uniform(i, -1.1e6, 1.1e6); },
                         [](int i) { return uniform(i, -1e-3, 1e-3); },
                         [](int i) { return (i - draws / 2) * (pi / 2); }, of_any_size};
  for (const Draw& draw : ranges) {
    EXPECT_LT(worst(draw, elementary::sin, std::sin), 0.9);
    EXPECT_LT(worst(draw, elementary::cos, std::cos), 0.9);
  }
}

TEST_F(Elementary, AnglesOfPointsErrByLessThanAUnitInTheLastPlace) {
  const Draw ranges[] = {[](int i) { return uniform(i, -1, 1); },
                         [](int i) { return std::ldexp(uniform(i, -1, 1), i % 70); }, of_any_size};
  for (const Draw& draw : ranges) {
    EXPECT_LT(worst_of_two(draw, elementary::atan2, std::atan2), 0.51);
    EXPECT_LT(worst_of_two(draw, elementary::hypot, std::hypot), 0.76);
  }
}

// Some C libraries compute exp and log of a long double with the precision of a double.
void skip_unless_longer(long double value) {
  if (value == static_cast<long double>(static_cast<double>(value)))
    GTEST_SKIP() << "the C library computes it no more exactly than a double";
}

TEST_F(Elementary, PowersOfEErrByLessThanAUnitInTheLastPlace) {
  skip_unless_longer(std::exp(1.0L));
  if (IsSkipped()) return;
  const Draw ranges[] = {[](int i) { return uniform(i, -745, 709.7); },
                         [](int i) { return uniform(i, -1, 1); },
                         [](int i) { return uniform(i, -1e-9, 1e-9); }};
  for (const Draw& draw : ranges) EXPECT_LT(worst(draw, elementary::exp, std::exp), 0.8);
}

TEST_F(Elementary, LogarithmsErrByLessThanAUnitInTheLastPlace) {
  skip_unless_longer(std::log(3.0L));
  if (IsSkipped()) return;
  const Draw ranges[] = {[](int i) { return uniform(i, 0, 2); },
                         [](int i) { return uniform(i, 0.999, 1.001); },
                         [](int i) { return std::fabs(of_any_size(i)); }};
  for (const Draw& draw : ranges) EXPECT_LT(worst(draw, elementary::log, std::log), 0.95);
}

// The doubles nearest to a multiple of pi/2 in their binade, and the largest double: the sines were
// computed with integers of 2400 bits.
TEST(ElementaryFunctions, TheDigitsOfPiCount) {
  EXPECT_EQ(elementary::cos(0x1.6ac5b262ca1ffp+849), -0x1.14ae72e6ba22fp-61);
  EXPECT_EQ(elementary::sin(pi), 0x1.1a62633145c07p-53);
  EXPECT_EQ(elementary::cos(pi / 2), 0x1.1a62633145c07p-54);
  EXPECT_EQ(elementary::sin(DBL_MAX), 0x1.452fc98b34e97p-8);
  EXPECT_EQ(elementary::sin(-DBL_MAX), -0x1.452fc98b34e97p-8);
  EXPECT_EQ(elementary::sin(1e22), -0x1.b453ab76bf397p-1);
}

TEST(ElementaryFunctions, ZerosAndWhatIsNoNumber) {
  for (const double zero : {0.0, -0.0}) {
    expect_same(elementary::sin(zero), zero);
    expect_same(elementary::cos(zero), 1);
    expect_same(elementary::exp(zero), 1);
    expect_same(elementary::log(zero), -infinity);
  }
  expect_same(elementary::log(1), 0);
  expect_same(elementary::log(infinity), infinity);
  expect_same(elementary::exp(infinity), infinity);
  expect_same(elementary::exp(-infinity), 0);
  for (const double x : {nan, infinity, -infinity}) {
    expect_same(elementary::sin(x), nan);
    expect_same(elementary::cos(x), nan);
  }
  expect_same(elementary::log(-1), nan);
  expect_same(elementary::log(nan), nan);
  expect_same(elementary::exp(nan), nan);
}

TEST(ElementaryFunctions, PointsAtZeroAndInfinity) {
  const double special[] = {0.0, -0.0, 1.0, -1.0, 5e-324, DBL_MAX, infinity, -infinity, nan};
  for (const double y : special) {
    for (const double x : special) {
      SCOPED_TRACE(testing::Message() << "y " << y << ", x " << x);
      expect_same(elementary::atan2(y, x), std::atan2(y, x));
      expect_same(elementary::hypot(x, y), std::hypot(x, y));
    }
  }
}

}  // namespace
}  // namespace robsim
