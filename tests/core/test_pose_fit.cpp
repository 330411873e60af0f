// The fit of a pose to the edges of two markers, in pictures drawn here.
#include "robsim/vision/fit/pose_fit.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "robsim/base/simd/cpu_path.hpp"
#include "robsim/vision/fit/edge_fit.hpp"
#include "robsim/vision/fit/light_step.hpp"
#include "robsim/vision/marker_vision.hpp"

namespace robsim {
namespace {

constexpr int width = 160;
constexpr int height = 120;
constexpr double radius = 9;
constexpr Point red_place{-12, 20};
constexpr Point blue_place{-12, -20};

Polygon disc(const Point& centre, double size = radius) {
  Polygon polygon;
  for (int i = 0; i < 48; ++i) {
    polygon.push_back(
        {centre.x + size * std::cos(2 * pi * i / 48), centre.y + size * std::sin(2 * pi * i / 48)});
  }
  return polygon;
}

struct Picture {
  std::vector<std::uint8_t> rgb = std::vector<std::uint8_t>(3 * width * height);
  ImageView view() const { return {rgb.data(), width, height, 3 * width}; }
};

struct Options {
  double noise = 0;        // standard deviation, levels
  int hidden_columns = 0;  // of the red marker's left side, grey
  double hidden_disc = 0;  // radius of a grey disc on its left rim
  double shade = 1;        // brightness beyond a line through the point:
  Point shade_at{};
  double shade_angle = 0;  // of its normal
};

// Where the middle of the red marker is in the picture.
Point red_in_picture(const Pose& pose) {
  const double cos = std::cos(pose.heading), sin = std::sin(pose.heading);
  return {pose.x + red_place.x * cos - red_place.y * sin,
          pose.y + red_place.x * sin + red_place.y * cos};
}

// Red and blue discs on a grey floor, each pixel the mean of 16 x 16 points.
Picture picture(const Pose& pose, const Options& options = {}) {
  Picture picture;
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, 1);
  const double cos = std::cos(pose.heading), sin = std::sin(pose.heading);
  const auto in_disc = [&](double u, double v, const Point& place) {
    const double x = u - pose.x - place.x * cos + place.y * sin;
    const double y = v - pose.y - place.x * sin - place.y * cos;
    return x * x + y * y < radius * radius;
  };
  const Point red_centre = red_in_picture(pose);
  const Point rim{red_centre.x - radius, red_centre.y};
  const double hidden = rim.x + options.hidden_columns;
  const auto is_shaded = [&](double u, double v) {
    return (u - options.shade_at.x) * std::cos(options.shade_angle) +
               (v - options.shade_at.y) * std::sin(options.shade_angle) >
           0;
  };
  constexpr int grid = 16;
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      double red = 0, blue = 0, light = 0;
      for (int i = 0; i < grid * grid; ++i) {
        const double x = u + (i % grid + 0.5) / grid - 0.5;
        const double y = v + (i / grid + 0.5) / grid - 0.5;
        const bool is_hidden = x < hidden || std::hypot(x - rim.x, y - rim.y) < options.hidden_disc;
        red += !is_hidden && in_disc(x, y, red_place);
        blue += in_disc(x, y, blue_place);
        light += is_shaded(x, y) ? options.shade : 1;
      }
      light /= grid * grid;
      red /= grid * grid;
      blue /= grid * grid;
      const double levels[3] = {170 + 40 * red - 140 * blue, 170 - 130 * red - 90 * blue,
                                170 - 130 * red + 30 * blue};
      for (int c = 0; c < 3; ++c) {
        const double level = light * levels[c] + options.noise * noise(random);
        picture.rgb[static_cast<std::size_t>(3 * (v * width + u) + c)] =
            static_cast<std::uint8_t>(std::clamp(std::lround(level), 0L, 255L));
      }
    }
  }
  return picture;
}

std::optional<PoseFit> fit(const Picture& picture, const Pose& start, double size = radius) {
  const MarkerShape red(disc(red_place, size), "red");
  const MarkerShape blue(disc(blue_place, size), "blue");
  return fit_pose(picture.view(), PlaneMap(), red, blue, start);
}

double distance(const Pose& a, const Pose& b) { return std::hypot(a.x - b.x, a.y - b.y); }

class PoseFits : public testing::TestWithParam<double> {};

TEST_P(PoseFits, FindThePoseOfACleanPicture) {
  const Pose pose{81.3, 58.6, GetParam()};
  const auto found = fit(picture(pose), {pose.x + 0.8, pose.y - 0.6, pose.heading + 0.03});
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->has_converged);
  EXPECT_LT(distance(found->pose, pose), 0.012);
  EXPECT_LT(std::fabs(wrap_angle(found->pose.heading - pose.heading)), 0.012 / 20);
  EXPECT_GT(found->signal_to_noise, 50);
}

INSTANTIATE_TEST_SUITE_P(AtHeadings, PoseFits, testing::Values(0, 0.4, 1.57, 2.9, -3.1, -1));

TEST(PoseFit, HasTheCovarianceOfItsErrors) {
  const Pose pose{81.3, 58.6, 0.7};
  const Picture clean = picture(pose);
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 20);
  double squared = 0;
  constexpr int pictures = 60;
  for (int k = 0; k < pictures; ++k) {
    Picture noisy = clean;
    for (std::uint8_t& level : noisy.rgb) {
      level = static_cast<std::uint8_t>(std::clamp(std::lround(level + noise(random)), 0L, 255L));
    }
    const auto found = fit(noisy, pose);
    ASSERT_TRUE(found);
    const Eigen::Vector3d error(found->pose.x - pose.x, found->pose.y - pose.y,
                                found->pose.heading - pose.heading);
    squared += error.dot(found->covariance.inverse() * error);
  }
  // chi-square of 180 degrees of freedom: within 4 standard deviations, and 6 % on the safe side
  EXPECT_NEAR(squared / (3 * pictures), 0.94, 4 * std::sqrt(2.0 / (3 * pictures)));
}

TEST(PoseFit, DoesNotMindADefinitionThatIsSomewhatWrong) {
  const Pose pose{81.3, 58.6, 0.7};
  const auto found = fit(picture(pose), pose, 1.05 * radius);
  ASSERT_TRUE(found);
  EXPECT_LT(distance(found->pose, pose), 0.02);
}

class LightSteps : public testing::TestWithParam<double> {};

TEST_P(LightSteps, OnAMarkerDoNotPullAtThePose) {
  const Pose pose{81.3, 58.6, 0.7};
  Options options;
  options.shade = 0.7;
  options.shade_at = red_in_picture(pose);
  options.shade_at.x += 2.3;
  options.shade_angle = GetParam();
  const auto found = fit(picture(pose, options), pose);
  ASSERT_TRUE(found);
  EXPECT_LT(distance(found->pose, pose), 0.02);  // 0.2 to 0.4 with one light for all pixels
  EXPECT_LT(found->misfit, 1.5);
  options.noise = 12;
  const auto noisy = fit(picture(pose, options), pose);
  ASSERT_TRUE(noisy);
  EXPECT_LT(distance(noisy->pose, pose), 0.15);
}

INSTANTIATE_TEST_SUITE_P(AtAngles, LightSteps, testing::Values(0, 0.6, 1.57, 2.2));

TEST(LightStep, IsFoundWhereItIs) {
  const Pose pose{81.3, 58.6, 0.7};
  const MarkerShape red(disc(red_place), "red");
  Options options;
  options.shade_at = red_in_picture(pose);
  for (const double angle : {0.0, 0.9, 2.2}) {
    options.shade_angle = angle;
    for (const double shade : {1.0, 0.7}) {
      options.shade = shade;
      const Picture drawn = picture(pose, options);
      fit::EdgeFit marker;
      fit::gather(drawn.view(), PlaneMap(), red, pose, fit::Ring{}, marker.pixels);
      fit::EdgeShift shift;
      shift.blur = 0.4;
      ASSERT_TRUE(marker.update(shift));
      EXPECT_EQ(fit::has_light_slope(marker), shade < 1) << angle;
      const auto step = fit::find_light_step(marker);
      ASSERT_EQ(step.has_value(), shade < 1) << angle;
      if (!step) continue;
      // the normal may point to either side
      const double along =
          std::fabs(step->normal_u * std::cos(angle) + step->normal_v * std::sin(angle));
      EXPECT_GT(along, std::cos(0.2)) << angle;
      const double off =
          options.shade_at.x * step->normal_u + options.shade_at.y * step->normal_v - step->offset;
      EXPECT_LT(std::fabs(off), 1.5) << angle;
      const auto sides = fit::divided(marker.pixels, *step);
      EXPECT_GT(sides[0].count, 50);
      EXPECT_GT(sides[1].count, 50);
      EXPECT_LT(sides[0].count + sides[1].count, marker.pixels.count);
    }
  }
}

TEST(PoseFit, TakesTheRestOfAMarkerThatIsPartlyHidden) {
  const Pose pose{81.3, 58.6, 0.1};
  const auto whole = fit(picture(pose), pose);
  const auto hidden = fit(picture(pose, {0, 3}), pose);
  ASSERT_TRUE(whole && hidden);
  EXPECT_LT(whole->misfit, 1.5);
  EXPECT_LT(distance(hidden->pose, pose), 0.05);  // the blob's centroid is off by 1.2 px
  EXPECT_GT(hidden->covariance(0, 0), whole->covariance(0, 0));
}

TEST(PoseFit, TakesTheRestOfAMarkerThatSomethingRoundHides) {
  const Pose pose{81.3, 58.6, 0.1};
  Options options;
  options.hidden_disc = 5;
  const auto hidden = fit(picture(pose, options), pose);
  ASSERT_TRUE(hidden);
  EXPECT_LT(distance(hidden->pose, pose), 0.1);
}

TEST(PoseFit, SaysThatTheMarkersAreOfAnotherShape) {
  const Pose pose{81.3, 58.6, 0.1};
  const auto square = [](const Point& centre) {
    const double half = radius * std::sqrt(pi) / 2;  // of the same area
    return Polygon{{centre.x - half, centre.y - half},
                   {centre.x + half, centre.y - half},
                   {centre.x + half, centre.y + half},
                   {centre.x - half, centre.y + half}};
  };
  const MarkerShape red(square(red_place), "red");
  const MarkerShape blue(square(blue_place), "blue");
  const Picture discs = picture(pose);
  const auto as_squares = fit_pose(discs.view(), PlaneMap(), red, blue, pose);
  const auto as_discs = fit(discs, pose);
  ASSERT_TRUE(as_squares && as_discs);
  EXPECT_LT(as_discs->misfit, 1.5);
  EXPECT_GT(as_squares->misfit, 2);
  EXPECT_GT(as_squares->covariance(0, 0), as_discs->covariance(0, 0));
}

TEST(PoseFit, ThereIsNoneWithoutAnEdge) {
  Picture grey;
  std::fill(grey.rgb.begin(), grey.rgb.end(), std::uint8_t{128});
  const auto found = fit(grey, {80, 60, 0});
  EXPECT_TRUE(!found || found->signal_to_noise < 3);
  EXPECT_FALSE(fit(grey, {-500, 60, 0}));
  EXPECT_FALSE(fit(grey, {1e12, 1e12, 0}));
}

TEST(PoseFit, GivesTheSameBitsOnEveryPath) {
  const Pose pose{81.3, 58.6, -2.2};
  const Picture noisy = picture(pose, {30, 2});
  const simd::CpuPath used = simd::cpu_path();
  std::vector<PoseFit> found;
  for (const simd::CpuPath path : simd::cpu_paths()) {
    simd::force_cpu_path(path);
    const auto one = fit(noisy, {pose.x + 0.5, pose.y, pose.heading});
    ASSERT_TRUE(one);
    found.push_back(*one);
  }
  simd::force_cpu_path(used);
  for (const PoseFit& one : found) {
    EXPECT_EQ(one.pose.x, found[0].pose.x);
    EXPECT_EQ(one.pose.y, found[0].pose.y);
    EXPECT_EQ(one.pose.heading, found[0].pose.heading);
    EXPECT_EQ(one.misfit, found[0].misfit);
    EXPECT_EQ(one.signal_to_noise, found[0].signal_to_noise);
    EXPECT_EQ(one.covariance, found[0].covariance);
  }
}

TEST(MarkerShape, KnowsHowFarItsOutlineIs) {
  const MarkerShape square({{-2, -2}, {2, -2}, {2, 2}, {-2, 2}}, "red");
  EXPECT_DOUBLE_EQ(square.perimeter(), 16);
  const MarkerShape::Table& table = square.table();
  const auto cell_at = [&](double x, double y) {
    const auto column = static_cast<int>((x - table.left()) * table.per_px());
    const auto row = static_cast<int>((y - table.top()) * table.per_px());
    return table.data()[row * MarkerShape::Table::cells + column];
  };
  const double cell = 1 / table.per_px();
  EXPECT_NEAR(cell_at(0.5, 0).distance, 1.5, cell);
  EXPECT_NEAR(cell_at(3, 0).distance, -1, cell);
  EXPECT_NEAR(cell_at(5, 5.9).distance, -std::hypot(3, 3.9), cell);
  EXPECT_NEAR(cell_at(3, 0).slope_x, -1, 1e-6);
  EXPECT_NEAR(cell_at(0, -1.5).slope_y, 1, 1e-6);
}

TEST(WeightedCentroid, IsThatOfTheMarker) {
  const Pose pose{81.3, 58.6, 0};
  const Picture clean = picture(pose);
  const Point truth{pose.x + red_place.x, pose.y + red_place.y};
  const PixelBox box{60, 69, 79, 88};
  const auto found = weighted_centroid(clean.view(), box, {69.5, 78.5});
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->centroid.x, truth.x, 0.04);
  EXPECT_NEAR(found->centroid.y, truth.y, 0.04);
  EXPECT_LT(found->variance, 0.01);
  Picture grey;
  EXPECT_FALSE(weighted_centroid(grey.view(), box, {69.5, 78.5}));
}

TEST(WeightedCentroid, TakesABoxAnywhere) {
  const Picture clean = picture({81.3, 58.6, 0});
  constexpr int least = std::numeric_limits<int>::min();
  constexpr int most = std::numeric_limits<int>::max();
  for (const PixelBox& box :
       {PixelBox{least, least, least + 1, least + 1}, PixelBox{most - 1, most - 1, most, most},
        PixelBox{width, 0, width + 5, 9}, PixelBox{-5, -5, 0, 0}}) {
    EXPECT_FALSE(weighted_centroid(clean.view(), box, {0, 0}));
  }
  weighted_centroid(clean.view(), {least, least, most, most}, {1e300, -1e300});
}

// A comb whose teeth are thinner than the ring around an edge: the ring is all of it.
TEST(EdgePixels, AreSoManyAtMost) {
  constexpr int side = 1200;
  Polygon comb;
  for (int i = 0; i < 500; ++i) {
    comb.push_back({i % 2 ? 550.0 : -500.0, i * 2.2 - 550.0});
  }
  comb.push_back({-550, 550});
  comb.push_back({-550, -552});
  const std::vector<std::uint8_t> rgb(static_cast<std::size_t>(3 * side * side), 90);
  const ImageView image{rgb.data(), side, side, 3 * side};
  fit::EdgePixels pixels;
  const auto gather = [&](const MarkerShape& shape) {
    fit::gather(image, PlaneMap(), shape, {600, 600, 0}, {}, pixels);
  };
  gather(MarkerShape(comb, "comb"));
  EXPECT_EQ(pixels.count, 0);
  EXPECT_TRUE(pixels.blocks.empty());
  gather(MarkerShape(disc({0, 0}, 500), "disc"));
  EXPECT_GT(pixels.count, 15000);
}

}  // namespace
}  // namespace robsim
