// Detection by hand-made blobs: which pair is chosen, and why it is refused.
#include "robsim/vision/locate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
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
