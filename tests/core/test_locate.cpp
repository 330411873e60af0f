// Detection by hand-made blobs: which pair is chosen, and why it is refused.
#include "robsim/vision/locate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "robsim/vision/explain_detection.hpp"

namespace robsim {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

MarkerLayout layout() {
  MarkerLayout markers = MarkerLayout::across(40, 14);
  markers.first.area = markers.second.area = 400;
  return markers;
}

Blob blob(const char* color, double u, double v, std::int64_t area, bool at_border = false) {
  return {color, area, {u, v}, {}, at_border};
}

Detection found(const std::vector<Blob>& red, const std::vector<Blob>& blue) {
  return detect({{"red", red}, {"blue", blue}}, layout(), PlaneMap());
}

TEST(Detect, FindsTheRobotThatFacesRight) {
  const Detection d = found({blob("red", 100, 110, 400)}, {blob("blue", 100, 70, 400)});
  ASSERT_EQ(d.result, DetectionResult::detected);
  EXPECT_DOUBLE_EQ(d.measurement->pose.x, 114);
  EXPECT_DOUBLE_EQ(d.measurement->pose.y, 90);
  EXPECT_DOUBLE_EQ(d.misfit, 0);
  EXPECT_EQ(d.runner_up, infinity);
}

TEST(Detect, TakesTheBetterOfTwoPairs) {
  const Detection d =
      found({blob("red", 100, 32, 400), blob("red", 100, 110, 400)}, {blob("blue", 100, 70, 400)});
  EXPECT_EQ(d.first->centroid.y, 110);
  EXPECT_NEAR(d.runner_up, std::pow(2 / (0.12 * 40), 2), 1e-12);
}

TEST(Detect, SaysWhyThereIsNone) {
  const Blob red = blob("red", 100, 110, 400), blue = blob("blue", 100, 70, 400);
  EXPECT_EQ(found({}, {}).result, DetectionResult::no_blobs);
  EXPECT_EQ(found({}, {blue}).result, DetectionResult::no_first_blob);
  EXPECT_EQ(found({red}, {}).result, DetectionResult::no_second_blob);
  EXPECT_EQ(found({red}, {blob("blue", 100, 70, 400, true)}).result, DetectionResult::at_border);
  EXPECT_EQ(found({red}, {blob("blue", 100, 50, 400)}).result, DetectionResult::distance);
  EXPECT_EQ(found({red}, {blob("blue", 100, 70, 100)}).result, DetectionResult::areas);
  EXPECT_EQ(found({red, blob("red", 100, 30, 400)}, {blue}).result, DetectionResult::ambiguous);
}

TEST(Detect, HasTheSameDigitsWhateverTheRolesAre) {
  const Blob red = blob("red", 101.3, 112.9, 400), blue = blob("blue", 97.7, 74.1, 400);
  MarkerLayout markers = layout();
  markers.first.position = {-9, 20};
  markers.second.position = {11, -18};
  MarkerLayout other = markers;
  std::swap(other.first, other.second);
  other.roles = MarkerRoles::front_back;
  const BlobsByColor blobs = {{"red", {red}}, {"blue", {blue}}};
  const Detection one = detect(blobs, markers, PlaneMap()), two = detect(blobs, other, PlaneMap());
  ASSERT_TRUE(one.measurement && two.measurement);
  EXPECT_EQ(one.measurement->pose.x, two.measurement->pose.x);
  EXPECT_EQ(one.measurement->pose.y, two.measurement->pose.y);
  EXPECT_EQ(one.measurement->pose.heading, two.measurement->pose.heading);
}

TEST(MarkerRoles, AreTrueOrContradicted) {
  for (const MarkerRoles roles : all_marker_roles) {
    EXPECT_FALSE(contradiction(roles, {9, 9}, {-9, -9}));
    EXPECT_TRUE(contradiction(roles, {-9, -9}, {9, 9}));
    EXPECT_TRUE(contradiction(roles, {9, 9}, {9, 9}));
  }
  EXPECT_EQ(fitting_roles({0, -9}, {1, 9}).roles, MarkerRoles::right_left);
  EXPECT_FALSE(fitting_roles({0, -9}, {1, 9}).is_first_right_or_front);
}

TEST(Detect, WithoutColoursThereAreNoBlobs) {
  EXPECT_EQ(detect({}, layout(), PlaneMap()).result, DetectionResult::no_blobs);
}

TEST(Detect, ExplainsTheLargeBlobsAndNotTheSpecks) {
  const Detection d =
      found({blob("red", 100, 190, 400), blob("red", 100, 110, 13)}, {blob("blue", 100, 70, 400)});
  EXPECT_EQ(d.result, DetectionResult::distance);
  EXPECT_DOUBLE_EQ(d.distance, 120);
  EXPECT_NE(explain(d).find("120.0 px"), std::string::npos);
}

}  // namespace
}  // namespace robsim
