// Lenses: maps through them, and resampled images.
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "robsim/imaging/intrinsics.hpp"
#include "robsim/imaging/plane_map.hpp"
#include "robsim/imaging/resampling.hpp"

namespace robsim {
namespace {

// --- maps

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

// --- resampled images

// Red grows to the right, green downwards, blue is steady.
Image ramps(int width, int height) {
  Image image(width, height);
  const WritableView view = image.writable_view();
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      std::uint8_t* const pixel = view.row(v) + 3 * u;
      pixel[0] = static_cast<std::uint8_t>(10 * u);
      pixel[1] = static_cast<std::uint8_t>(8 * v);
      pixel[2] = 77;
    }
  }
  return image;
}

Image warped(const Image& source, int width, int height, const std::function<Point(Point)>& place) {
  Image image(width, height);
  Warp(width, height, source.width(), source.height(), place)
      .apply(source.view(), image.writable_view());
  return image;
}

TEST(Warp, GivesTheSameForTheSamePlaces) {
  const Image source = ramps(20, 30);
  const Image image = warped(source, 20, 30, [](Point p) { return p; });
  for (int v = 0; v < 30; ++v) {
    for (int i = 0; i < 60; ++i) EXPECT_EQ(image.row(v)[i], source.row(v)[i]) << i << ", " << v;
  }
}

TEST(Warp, MixesTheNeighboursByDistanceAndRounds) {
  const Image image =
      warped(ramps(20, 30), 18, 28, [](Point p) { return Point{p.x + 0.3, p.y + 0.7}; });
  for (int v = 0; v < 28; ++v) {
    for (int u = 0; u < 18; ++u) {
      const std::uint8_t* const pixel = image.row(v) + 3 * u;
      EXPECT_NEAR(pixel[0], 10 * (u + 0.3), 0.55);  // rounded, and 1/256 px
      EXPECT_NEAR(pixel[1], 8 * (v + 0.7), 0.55);
      EXPECT_EQ(pixel[2], 77);
    }
  }
}

TEST(Warp, KeepsTheBrightestAndTheDarkest) {
  Image white(5, 4);
  for (int v = 0; v < 4; ++v) std::fill_n(white.writable_view().row(v), 15, std::uint8_t{255});
  const Image image = warped(white, 5, 4, [](Point p) { return Point{p.x * 0.83, p.y * 0.61}; });
  for (int v = 0; v < 4; ++v) {
    for (int i = 0; i < 15; ++i) EXPECT_EQ(image.row(v)[i], 255);
  }
}

TEST(Warp, IsGreyOutsideAndReachesHalfAPixelBeyondTheOutermostCentres) {
  const Image source = ramps(20, 30);
  const Image image = warped(source, 24, 1, [](Point p) { return Point{p.x - 1.6, 29.4}; });
  EXPECT_EQ(image.row(0)[0], 128);  // at -1.6
  EXPECT_EQ(image.row(0)[3], 128);  // at -0.6
  EXPECT_EQ(image.row(0)[6], 4);    // at 0.4
  EXPECT_EQ(image.row(0)[3 * 21], 190);
  EXPECT_EQ(image.row(0)[3 * 22], 128);
  const Image nowhere = warped(source, 1, 1, [](Point) { return Point{NAN, 2}; });
  EXPECT_EQ(nowhere.row(0)[1], 128);
}

TEST(Warp, LaysOverWhatIsNotTransparent) {
  // On the left it hides all, in the middle half of it, on the right nothing.
  Image black(6, 4), white(6, 4), image(6, 4);
  for (int v = 0; v < 4; ++v) {
    for (int i = 0; i < 18; ++i) {
      black.writable_view().row(v)[i] = i < 6 ? 200 : i < 12 ? 100 : 0;
      white.writable_view().row(v)[i] = i < 6 ? 200 : i < 12 ? 227 : 255;
      image.writable_view().row(v)[i] = 60;
    }
  }
  const Warp warp(6, 4, 6, 4, [](Point p) { return p; });
  warp.lay_over(black.view(), white.view(), {0, 0, 6, 2}, image.writable_view());
  EXPECT_EQ(image.row(0)[0], 200);
  EXPECT_EQ(image.row(0)[3 * 2], 130);  // 100 + 60 (227 - 100) / 255
  EXPECT_EQ(image.row(0)[3 * 4], 60);
  EXPECT_EQ(image.row(3)[0], 60);  // outside of the box
  EXPECT_THROW(warp.lay_over(black.view(), ramps(6, 5).view(), {}, image.writable_view()),
               std::invalid_argument);
}

TEST(Warp, RefusesImagesOfOtherSizes) {
  const Warp warp(4, 4, 8, 8, [](Point p) { return p; });
  Image image(4, 4);
  EXPECT_THROW(warp.apply(ramps(8, 9).view(), image.writable_view()), std::invalid_argument);
  Image other(5, 4);
  EXPECT_THROW(warp.apply(ramps(8, 8).view(), other.writable_view()), std::invalid_argument);
  EXPECT_THROW(Warp(4, 4, 1, 8, [](Point p) { return p; }), std::invalid_argument);
}

}  // namespace
}  // namespace robsim
