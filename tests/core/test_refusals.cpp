// What the core refuses by itself. Python does not get that far: the bindings refuse it, or cannot
// pass it.
#include <gtest/gtest.h>

#include <exception>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "robsim/base/geometry.hpp"
#include "robsim/estimation/least_squares.hpp"
#include "robsim/imaging/plane_map.hpp"
#include "robsim/model/robot_model.hpp"
#include "robsim/simulation/robot/controllers.hpp"
#include "robsim/simulation/trace.hpp"
#include "robsim/simulation/world/simulated_world.hpp"
#include "robsim/vision/color/color_class.hpp"
#include "robsim/vision/locate.hpp"

namespace robsim {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

// The message with which a call is refused.
std::string refusal(const std::function<void()>& call) {
  try {
    call();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "nothing";
}

TEST(Refusals, ASampleWithoutItsOutput) {
  const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> phi =
      Eigen::MatrixXd::Ones(3, 2);
  EXPECT_EQ(refusal([&] { least_squares(phi, Eigen::VectorXd::Ones(2)); }),
            "y must have as many samples as phi has rows, got 2 and 3");
  EXPECT_EQ(refusal([&] { least_squares(phi.topRows(0), Eigen::VectorXd()); }),
            "phi must not be empty");
}

TEST(Refusals, PolygonsThatAreNotFinite) {
  for (const Point& corner : {Point{nan, 1}, Point{0, infinity}}) {
    EXPECT_EQ(refusal([&] { check_polygon({{0, 0}, {1, 0}, corner}, "red"); }),
              "red must be a polygon of finite points, got NaN or inf");
  }
}

TEST(Refusals, MarkersThatNoRobotHas) {
  const auto refused = [](double area, int blobs) {
    MarkerLayout markers = MarkerLayout::across(40, 12);
    markers.second.area = area;
    markers.maximum_blobs = blobs;
    return refusal([&] { check_marker_layout(markers); });
  };
  EXPECT_EQ(refused(nan, 1), "nothing");
  EXPECT_EQ(refused(0, 1), "marker area must be positive and finite, or NaN, got 0");
  EXPECT_EQ(refused(infinity, 1), "marker area must be positive and finite, or NaN, got inf");
  EXPECT_EQ(refused(100, 0), "maximum_blobs must be at least 1, got 0");
  EXPECT_EQ(refusal([] { MarkerLayout::across(40, 12, {"green", "green"}); }),
            "colors must be the names of two different colours, got 'green' and 'green'");
  EXPECT_EQ(refusal([] { MarkerLayout::across(40, 12, {"green", ""}); }),
            "colors must be the names of two different colours, got 'green' and ''");
}

TEST(Refusals, RobotsAndColorsThatThereAreNot) {
  RobotParameters torque;
  torque.motor_gain[1] = nan;
  EXPECT_EQ(refusal([&] { check_parameters(torque); }),
            "motor_gain must be finite, got nan: a motor needs a torque");
  EXPECT_EQ(refusal([] { RobotModel(AxisMatrix::Constant(nan), 0.2); }),
            "theta must be finite, got NaN or inf");
  EXPECT_EQ(refusal([] { check_color_class({"", {0, 0, 0}, {255, 255, 255}}); }),
            "name of a colour class must not be empty");
}

TEST(Refusals, PointsWithoutTheirPositions) {
  const std::vector<Point> four = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  EXPECT_EQ(refusal([&] { PlaneMap::from_points({four.begin(), four.end() - 1}, four); }),
            "pixels and positions must have as many points, at least four, got 3 and 4");
  EXPECT_EQ(refusal([&] { PlaneMap::from_points({{0, 0}}, {{0, 0}}); }),
            "pixels and positions must have as many points, at least four, got 1 and 1");
}

TEST(Refusals, InputsThatAreNotFinite) {
  EXPECT_EQ(refusal([] { Replay({{0, 0}, {nan, 0}}); }), "u must be finite (V)");
  EXPECT_EQ(refusal([] { Replay({{0, infinity}}); }), "u must be finite (V)");
}

TEST(Refusals, AStepBeforeTheRecordedInputs) {
  Step step(std::make_shared<RunGuard>(), nullptr);
  step.k = -1;
  EXPECT_EQ(refusal([&] { Replay({{0, 0}})(step); }),
            "the recorded inputs have 1 rows, there is none for step -1");
}

TEST(Refusals, AColumnThatATraceDoesNotHave) {
  EXPECT_EQ(refusal([] { trace_group("speed"); }), "there is no group of columns 'speed'");
}

TEST(Refusals, AStartThatIsNotFinite) {
  for (const Pose& start : {Pose{nan, 0, 0}, Pose{0, infinity, 0}, Pose{0, 0, nan}}) {
    WorldOptions options;
    options.start = start;
    EXPECT_EQ(refusal([&] { SimulatedWorld{options}; }),
              "start must be a finite pose, got NaN or inf");
  }
}

}  // namespace
}  // namespace robsim
