// Images of which each pixel comes from a place of its own in another.
#include "robsim/imaging/resampling.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace robsim {
namespace {

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
