// Lenses, and the local scale of maps through them.
#include "robsim/imaging/intrinsics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "robsim/imaging/plane_map.hpp"

namespace robsim {
namespace {

constexpr Point focal{400, 380};
constexpr Point centre{319.5, 239.5};
constexpr Point tiny{1e-3, 1e-3};

TEST(Intrinsics, MoveWhatIsAFocalLengthAwayByTheSumOfTheCoefficients) {
  const Intrinsics lens(focal, centre, {-0.04, 0.01, 0, 0, 0.002});
  const Point right = lens.distorted({centre.x + focal.x, centre.y});
  EXPECT_NEAR(right.x, centre.x + focal.x * 0.972, 1e-9);
  EXPECT_EQ(right.y, centre.y);
  const Point middle = lens.distorted(centre);
  EXPECT_EQ(middle.x, centre.x);
  EXPECT_EQ(middle.y, centre.y);
}

TEST(Intrinsics, FindTheWayBackToRounding) {
  for (const Intrinsics::Distortion& distortion : {Intrinsics::Distortion{-0.04, 0, 0, 0, 0},
                                                   {0.3, 0, 0, 0, 0},
                                                   {-0.2, 0.05, 0, 0, 0},
                                                   {0.1, -0.1, 0, 0, 0},
                                                   {0, 0.4, 0, 0, 0},
                                                   {-0.14, 0, 0, 0, 0},
                                                   {0, 0, 0, 0, -0.05},
                                                   {-0.3, 0.12, 0.002, -0.003, -0.02},
                                                   {0, 0, 0.02, 0.02, 0}}) {
    const Intrinsics lens(focal, centre, distortion);
    for (const Point& pixel :
         {Point{0, 0}, {639, 479}, {639, 0}, {319.5, 0}, {320, 240}, {11, 400}}) {
      const Point back = lens.distorted(lens.ideal(pixel));
      EXPECT_NEAR(back.x, pixel.x, 1e-11) << distortion[0] << ", " << distortion[1];
      EXPECT_NEAR(back.y, pixel.y, 1e-11) << distortion[0] << ", " << distortion[1];
    }
  }
}

TEST(Intrinsics, ShowNothingWhereTheyWouldFold) {
  // r (1 - r^2 / 3) grows up to r = 1, where it is 2/3.
  const Intrinsics lens(focal, centre, {-1 / 3.0, 0, 0, 0, 0});
  const auto is_nowhere = [](const Point& p) { return std::isnan(p.x) && std::isnan(p.y); };
  EXPECT_FALSE(is_nowhere(lens.distorted({centre.x + 0.999 * focal.x, centre.y})));
  EXPECT_TRUE(is_nowhere(lens.distorted({centre.x + 1.001 * focal.x, centre.y})));
  EXPECT_FALSE(is_nowhere(lens.ideal({centre.x, centre.y - 0.666 * focal.y})));
  EXPECT_TRUE(is_nowhere(lens.ideal({centre.x, centre.y - 0.667 * focal.y})));
  EXPECT_TRUE(is_nowhere(lens.ideal({centre.x + 1e6, centre.y})));
  EXPECT_TRUE(is_nowhere(lens.ideal({NAN, 1})));
  // 1 + 6 p2 x is 0 at x = -1.
  const Intrinsics skewed(focal, centre, {0, 0, 0, 1 / 6.0, 0});
  EXPECT_FALSE(is_nowhere(skewed.distorted({centre.x - 0.999 * focal.x, centre.y})));
  EXPECT_TRUE(is_nowhere(skewed.distorted({centre.x - 1.001 * focal.x, centre.y})));
}

TEST(Intrinsics, RefuseWhatIsNoLens) {
  EXPECT_THROW(Intrinsics({0, 1}, centre), std::invalid_argument);
  EXPECT_THROW(Intrinsics({1, -1}, centre), std::invalid_argument);
  EXPECT_THROW(Intrinsics(focal, {NAN, 0}), std::invalid_argument);
  EXPECT_THROW(Intrinsics(focal, centre, {0, 0, 0, 0, INFINITY}), std::invalid_argument);
}

// |d(x, y) / d(u, v)| by differences
double measured_scale(const PlaneMap& map, const Point& p) {
  const Point left = map.to_world({p.x - tiny.x, p.y}), right = map.to_world({p.x + tiny.x, p.y});
  const Point above = map.to_world({p.x, p.y - tiny.y}), below = map.to_world({p.x, p.y + tiny.y});
  return std::abs((right.x - left.x) * (below.y - above.y) -
                  (right.y - left.y) * (below.x - above.x)) /
         (4 * tiny.x * tiny.y);
}

TEST(PlaneMap, KnowsItsScaleThroughALens) {
  const PlaneMap::Matrix matrix{1.9, 0.3, -120, -0.1, 2.4, -60, 1e-4, 5e-4, 1};
  const PlaneMap map(matrix, Intrinsics(focal, centre, {-0.3, 0.12, 0.002, -0.003, -0.02}));
  for (const Point& pixel : {Point{0, 0}, {600, 400}, {100, 300}, {639, 0}}) {
    EXPECT_NEAR(map.area_scale(pixel) / measured_scale(map, pixel), 1, 1e-7);
    EXPECT_GT(std::abs(map.area_scale(pixel) / PlaneMap(matrix).area_scale(pixel) - 1), 1e-3);
  }
}

}  // namespace
}  // namespace robsim
