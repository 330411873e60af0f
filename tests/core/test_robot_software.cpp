// The robot half by itself: observations and a camera of the test go in, inputs come out.
#include "robsim/simulation/robot/robot_software.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <vector>

namespace robsim {
namespace {

const MarkerLayout markers = MarkerLayout::across(40, 12);
const Pose shown{111.5, 79.5, 0};  // by the markers of the camera's image

void paint(Image& image, int left, int top, const std::array<std::uint8_t, 3>& color) {
  const WritableView view = image.writable_view();
  for (int v = top; v < top + 10; ++v) {
    for (int u = left; u < left + 10; ++u) std::copy_n(color.data(), 3, view.row(v) + 3 * u);
  }
}

// Shows a robot that faces right: blue on its left, red on its right.
class StillCamera : public Camera {
 public:
  StillCamera() {
    image_ = Image(200, 160);
    const WritableView view = image_.writable_view();
    for (int v = 0; v < view.height; ++v) std::fill_n(view.row(v), 3 * view.width, 100);
    paint(image_, 95, 55, {0, 0, 255});
    paint(image_, 95, 95, {255, 0, 0});
  }

  Frame frame() override {
    ++looks;
    Frame frame;
    frame.image = image_;
    return frame;
  }

  int looks = 0;

 private:
  Image image_;
};

class RobotSoftwareTest : public ::testing::Test {
 protected:
  RobotSoftwareTest()
      : robot({{{"red", {0, 0, 200}, {255, 255, 255}}, {"blue", {0, 200, 0}, {255, 255, 255}}},
               markers,
               1,
               0},
              std::make_shared<RunGuard>()) {
    Stages& stages = robot.stages();
    stages.define_model = [] { return RobotModel(); };
    stages.init_parameter_estimator = [](const RobotModel&) {
      return std::make_shared<RecursiveEstimator>(std::make_shared<GuardedLeastSquares>(5, 3));
    };
    stages.measure = {
        [this](const StepPointer& step) {
          ++measured;
          return detect(step->find_blobs(), step->markers(), step->look()->plane_map).measurement;
        },
        false};
    stages.estimate_state = {[](const StepPointer& step) {
                               Estimate estimate;
                               if (step->measurement) estimate.pose = step->measurement->pose;
                               estimate.covariance.setIdentity();
                               return estimate;
                             },
                             false};
    stages.control = {[](const StepPointer& step) {
                        return Input{step->estimate->pose.x, static_cast<double>(step->k)};
                      },
                      false};
  }

  // A step as a loop takes it.
  Input turn(std::int64_t k, const Observation& observation = {}) {
    robot.begin_step(k, 0.2, observation, camera);
    robot.estimate_parameters();
    robot.measure();
    robot.estimate_state();
    robot.control();
    robot.set_last_input(*robot.step()->u);
    return *robot.step()->u;
  }

  std::shared_ptr<StillCamera> camera = std::make_shared<StillCamera>();
  RobotSoftware robot;
  int measured = 0;
};

TEST_F(RobotSoftwareTest, WhatTheCameraShowsBecomesAnInput) {
  robot.start();
  Observation observation;
  observation.t = 7;
  const Input u = turn(3, observation);
  EXPECT_NEAR(u.u1, shown.x, 1e-9);
  EXPECT_EQ(u.u2, 3);
  EXPECT_EQ(robot.step()->t, 7);
  EXPECT_NEAR(robot.held()->y, shown.y, 1e-9);
  EXPECT_NEAR(robot.held()->heading, 0, 1e-9);
  EXPECT_EQ(camera->looks, 1);
}

TEST_F(RobotSoftwareTest, TheCameraIsAskedOnlyIfSomebodyLooks) {
  robot.stages().measure = {};
  robot.start();
  turn(0);
  EXPECT_EQ(camera->looks, 0);
  EXPECT_NE(robot.step()->look(), nullptr);
  robot.step()->look();
  EXPECT_EQ(camera->looks, 1);
}

TEST_F(RobotSoftwareTest, AStepWithoutAFrameIsNotMeasured) {
  robot.start();
  turn(0);
  Observation observation;
  observation.has_frame = false;
  EXPECT_EQ(turn(1, observation).u1, 0);
  EXPECT_EQ(measured, 1);
  EXPECT_EQ(robot.step()->look(), nullptr);
  EXPECT_TRUE(robot.step()->find_blobs().at("red").empty());
  EXPECT_NEAR(robot.held()->x, shown.x, 1e-9);  // the last pose that was seen
}

TEST_F(RobotSoftwareTest, AMeasurementThatIsBroughtStands) {
  robot.start();
  Observation observation;
  observation.measurement = Measurement{{1, 2, 3}};
  EXPECT_EQ(turn(0, observation).u1, 1);
  EXPECT_EQ(robot.held()->heading, 3);
  EXPECT_EQ(measured, 0);
  EXPECT_EQ(camera->looks, 0);
}

TEST_F(RobotSoftwareTest, ACallbackMayMeasureAgain) {
  robot.stages().measure = {[](const StepPointer& step) {
                              Measurement twice = *step->measurement;
                              twice.pose.x *= 2;
                              return std::optional(twice);
                            },
                            true};
  robot.start();
  Observation observation;
  observation.measurement = Measurement{{1, 2, 3}};
  EXPECT_EQ(turn(0, observation).u1, 2);
}

TEST_F(RobotSoftwareTest, TheLastInputIsWhatWasSentUnlessTheWorldKnowsBetter) {
  robot.start();
  const Input u = turn(0);
  turn(1);
  EXPECT_EQ(robot.step()->last_u.u1, u.u1);
  robot.set_last_input({0.25, -0.25});
  turn(2);
  EXPECT_EQ(robot.step()->last_u.u2, -0.25);
  Observation observation;
  observation.last_u = Input{5, 6};
  turn(3, observation);
  EXPECT_EQ(robot.step()->last_u.u1, 5);
}

TEST_F(RobotSoftwareTest, ASampleThatIsBroughtIsTakenBeforeOneThatIsMade) {
  robot.stages().estimate_parameters = {[](const StepPointer& step) -> std::optional<AxisMatrix> {
                                          if (!step->has_sample()) return std::nullopt;
                                          return step->estimator->update(*step);
                                        },
                                        false};
  robot.start();
  const Sample brought{regression({3, 1, 0.2}, {2, 1, 0.1}, {1, 1, 0}, {1, 0.5}), 4};
  const Sample made{regression({9, 9, 0}, {8, 8, 0}, {7, 7, 0}, {1, 1}), 5};
  RecursiveLeastSquares alone(5, 3);
  AxisMatrix theta;
  alone.update(brought.regression.phi.data(), brought.regression.y.data(), 1, theta.data());

  Observation observation;
  observation.sample = brought;
  robot.begin_step(0, 0.2, observation, camera);
  robot.estimate_parameters();
  EXPECT_EQ(robot.step()->find_sample()->k, 4);
  EXPECT_EQ(*robot.step()->parameters, theta);
  robot.begin_step(1, 0.2, {}, camera);
  EXPECT_EQ(*robot.step()->parameters, theta);  // until there are newer ones
  robot.estimate_parameters();
  EXPECT_EQ(*robot.step()->parameters, theta);
  robot.step()->set_sample(made);
  robot.estimate_parameters();
  EXPECT_NE(*robot.step()->parameters, theta);
}

TEST_F(RobotSoftwareTest, AStepThatIsKeptStaysWhatItWas) {
  robot.start();
  turn(0);
  const StepPointer kept = robot.step();
  turn(1);
  EXPECT_EQ(kept->k, 0);
  EXPECT_NEAR(kept->measurement->pose.x, shown.x, 1e-9);
  EXPECT_NE(kept->look(), nullptr);  // measured, so that somebody has looked
  const Step* unkept = robot.step().get();
  turn(2);
  EXPECT_EQ(robot.step().get(), unkept);
}

TEST_F(RobotSoftwareTest, AKeptStepThatNobodyLookedAtHasNoFrame) {
  robot.stages().measure = {};
  robot.start();
  turn(0);
  const StepPointer kept = robot.step();
  turn(1);
  EXPECT_THROW(kept->look(), std::runtime_error);
}

TEST_F(RobotSoftwareTest, TheFurtherStateKeepsItsSize) {
  robot.stages().estimate_state = {[](const StepPointer& step) {
                                     Estimate estimate;
                                     estimate.covariance.setIdentity();
                                     estimate.state.resize(static_cast<std::size_t>(step->k));
                                     return estimate;
                                   },
                                   false};
  robot.start();
  turn(0);
  turn(2);
  EXPECT_THROW(turn(3), std::invalid_argument);
}

TEST_F(RobotSoftwareTest, AResetForgetsTheRun) {
  EXPECT_FALSE(robot.step());
  EXPECT_FALSE(robot.has_started());
  robot.start();
  turn(0);
  robot.reset();
  EXPECT_FALSE(robot.has_started());
  EXPECT_FALSE(robot.step());
  robot.start();
  EXPECT_FALSE(robot.held());
  turn(0);
  EXPECT_EQ(robot.step()->last_u.u1, 0);
}

}  // namespace
}  // namespace robsim
