// The simulated world in real time and its camera. No assertion is about how long something takes.
#include "robsim/lab/laboratory/laboratory_camera.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include "robsim/base/system.hpp"

namespace robsim {
namespace {

constexpr int side = 64;
constexpr double dt = 0.004;  // s

Layer grey_floor() {
  Image image(side, side);
  const WritableView view = image.writable_view();
  for (int v = 0; v < side; ++v) std::fill_n(view.row(v), 3 * side, std::uint8_t{120});
  return {image, image};
}

std::shared_ptr<const Scene> make_scene() {
  const std::vector<std::uint8_t> white(4 * 9 * 9, 255);
  const PlaneMap camera = PlaneMap::scaled(side, side, side, side);
  return std::make_shared<Scene>(
      Background(grey_floor(), grey_floor(), side, 1),
      RobotImage(premultiplied(white.data(), 9, 9), {4, 4}, 1, 0, 0, camera), camera);
}

// Another input in each step: 1, 2, 3, ... by the middle of the time asked for.
struct Staircase : ReceivedInput {
  Input mean(double from, double to) const override {
    ++calls;
    if (calls == 1) start = from;
    const double step = std::round(((from + to) / 2 - start) / dt + 0.5);
    return {step, -step};
  }
  mutable std::atomic<int> calls{0};
  mutable std::atomic<double> start{0};
};

std::shared_ptr<Laboratory> make_laboratory(
    const std::shared_ptr<const ReceivedInput>& input = std::make_shared<Staircase>()) {
  WorldOptions options;
  options.area = {side, side, Boundary::bounce};
  options.camera = PlaneMap::scaled(side, side, side, side);
  options.width = options.height = side;
  options.robot_radius = 5;
  options.start = {32, 32, 0};
  RobotParameters parameters;
  parameters.dt = dt;
  return std::make_shared<Laboratory>(std::make_shared<SimulatedWorld>(options),
                                      RobotModel(parameters), input);
}

LaboratoryCamera make_camera(const std::shared_ptr<Laboratory>& laboratory,
                             const CameraFaults& faults = {}) {
  LaboratoryCameraOptions options;
  options.faults = faults;
  return {laboratory, make_scene(), options};
}

std::vector<Captured> frames_of(LaboratoryCamera& camera, std::size_t count) {
  ImagePool pool;
  std::vector<Captured> frames;
  while (frames.size() < count) {
    if (const auto frame = camera.next(pool)) frames.push_back(*frame);
  }
  return frames;
}

std::int64_t tick_of(const Captured& frame) { return std::llround(*frame.device_time / dt); }

// A laboratory, and its camera, which is open.
struct Opened {
  explicit Opened(const CameraFaults& faults = {}) : camera(make_camera(laboratory, faults)) {
    camera.open();
  }
  std::shared_ptr<Laboratory> laboratory = make_laboratory();
  LaboratoryCamera camera;
};

CaptureFault fault_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const CaptureError& error) {
    return error.fault();
  }
  ADD_FAILURE() << "no error";
  return CaptureFault::end;
}

TEST(Laboratory, MovesTheRobotByTheInputsOfItsTicks) {
  const auto laboratory = make_laboratory();
  laboratory->start();
  while (laboratory->record().ticks.size() < 50) sleep_until(monotonic_now() + dt);
  const Laboratory::Record record = laboratory->record();
  RobotParameters parameters;
  parameters.dt = dt;
  const RobotModel model(parameters);
  Pose pose{32, 32, 0};
  Pose before = pose;
  for (std::size_t k = 1; k < record.ticks.size(); ++k) {
    const Laboratory::Tick& tick = record.ticks[k];
    EXPECT_EQ(tick.last_u.u1, static_cast<double>(k));
    const Pose next = model.predict(pose, before, tick.last_u);
    if (std::hypot(next.x - 32, next.y - 32) > 20) break;  // it bounces soon
    EXPECT_EQ(tick.pose.x, next.x) << k;
    EXPECT_EQ(tick.pose.heading, wrap_angle(next.heading)) << k;
    before = pose;
    pose = next;
    pose.heading = wrap_angle(pose.heading);
  }
}

TEST(Laboratory, ExposesAtItsTicksAndSaysWhichItShowed) {
  Opened opened;
  auto& [laboratory, camera] = opened;
  const auto frames = frames_of(camera, 30);
  const Laboratory::Record record = laboratory->record();
  Renderer renderer(make_scene());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const std::int64_t k = tick_of(frames[i]);
    const Laboratory::Tick& tick = record.ticks[static_cast<std::size_t>(k)];
    EXPECT_EQ(*frames[i].exposed, tick.time);
    EXPECT_EQ(tick.shown, k);
    EXPECT_GE(frames[i].arrived, tick.time);
    const Image expected = renderer.render(tick.pose);
    for (int v = 0; v < side; ++v) {
      EXPECT_TRUE(std::equal(expected.row(v), expected.row(v) + 3 * side, frames[i].image.row(v)));
    }
  }
}

TEST(Laboratory, DropsRepeatsAndTearsAsItsSeedSays) {
  CameraFaults faults;
  faults.dropped = faults.repeated = faults.torn = 0.2;
  faults.seed = 7;
  Opened opened(faults);
  auto& [laboratory, camera] = opened;
  const auto frames = frames_of(camera, 60);
  const Laboratory::Record record = laboratory->record();
  std::int64_t last = -1;
  int repeats = 0;
  for (const Captured& frame : frames) {
    const std::int64_t k = tick_of(frame);
    EXPECT_FALSE(faults.drops(k));
    EXPECT_EQ(frame.is_complete, !faults.tears(k));
    const std::int64_t shown = record.ticks[static_cast<std::size_t>(k)].shown;
    if (!frame.is_complete) {
      EXPECT_EQ(shown, -1);
    } else {
      const bool is_repeated = last >= 0 && faults.repeats(k);
      EXPECT_EQ(shown, is_repeated ? last : k);
      last = shown;
      repeats += is_repeated;
    }
  }
  EXPECT_GT(repeats, 0);
}

TEST(Laboratory, SendsAllFramesLateInTheirOrder) {
  CameraFaults faults;
  faults.late = 0.3;
  faults.lateness = 2.5 * dt;
  Opened opened(faults);
  auto& [laboratory, camera] = opened;
  std::int64_t last = -1;
  for (const Captured& frame : frames_of(camera, 40)) {
    const std::int64_t k = tick_of(frame);
    EXPECT_GT(k, last);
    EXPECT_GE(frame.arrived, *frame.exposed + faults.lateness_of(k));
    last = k;
  }
}

TEST(Laboratory, IsSilentInAStall) {
  CameraFaults faults;
  faults.stall = {5 * dt, 10 * dt};
  Opened opened(faults);
  auto& [laboratory, camera] = opened;
  for (const Captured& frame : frames_of(camera, 20)) {
    const std::int64_t k = tick_of(frame);
    EXPECT_TRUE(k < 5 || k >= 15) << k;
  }
  laboratory->stall(1e6);
  ImagePool pool;
  while (camera.next(pool)) {
  }
  EXPECT_FALSE(camera.next(pool));
}

TEST(Laboratory, GoesOnWithoutItsCamera) {
  Opened opened;
  auto& [laboratory, camera] = opened;
  const std::int64_t before = tick_of(frames_of(camera, 3).back());
  std::thread hand([&] { laboratory->unplug(); });
  ImagePool pool;
  EXPECT_EQ(fault_of([&] {
              while (true) camera.next(pool);
            }),
            CaptureFault::unplugged);
  hand.join();
  camera.close();
  EXPECT_EQ(fault_of([&] { camera.open(); }), CaptureFault::no_camera);
  const std::size_t ticks = laboratory->record().ticks.size();
  while (laboratory->record().ticks.size() < ticks + 10) sleep_until(monotonic_now() + dt);
  laboratory->plug_in();
  camera.open();
  EXPECT_GE(tick_of(frames_of(camera, 1)[0]), before + 10);
}

TEST(Laboratory, IsUnpluggedWhenOrdered) {
  CameraFaults faults;
  faults.unplugged = {3 * dt, 20 * dt};
  Opened opened(faults);
  auto& [laboratory, camera] = opened;
  ImagePool pool;
  EXPECT_EQ(fault_of([&] {
              while (true) camera.next(pool);
            }),
            CaptureFault::unplugged);
  camera.close();
  while (laboratory->record().ticks.size() < 25) sleep_until(monotonic_now() + dt);
  camera.open();
  EXPECT_GE(tick_of(frames_of(camera, 1)[0]), 23);
}

TEST(Laboratory, HasOneCamera) {
  Opened opened;
  auto& [laboratory, camera] = opened;
  LaboratoryCamera other = make_camera(laboratory);
  EXPECT_EQ(fault_of([&] { other.open(); }), CaptureFault::busy);
  other.close();
  EXPECT_EQ(frames_of(camera, 2).size(), 2u);
  camera.close();
  other.open();
  EXPECT_EQ(frames_of(other, 2).size(), 2u);
}

TEST(Laboratory, EndsTheWaitForAFrame) {
  CameraFaults faults;
  const auto laboratory = make_laboratory();
  LaboratoryCameraOptions options;
  options.delay = 1e6;
  LaboratoryCamera camera(laboratory, make_scene(), options);
  camera.open();
  std::atomic<bool> is_over{false};
  std::thread interrupter([&] {
    while (!is_over) {
      camera.interrupt();
      sleep_until(monotonic_now() + dt);
    }
  });
  ImagePool pool;
  EXPECT_FALSE(camera.next(pool));
  is_over = true;
  interrupter.join();
  laboratory->close();
  EXPECT_EQ(fault_of([&] { camera.next(pool); }), CaptureFault::failed);
  camera.close();
  EXPECT_EQ(fault_of([&] { camera.open(); }), CaptureFault::failed);
}

TEST(Laboratory, SaysWhatEndedTheWorld) {
  struct Broken : ReceivedInput {
    Input mean(double, double) const override { return {NAN, NAN}; }
  };
  const auto laboratory = make_laboratory(std::make_shared<Broken>());
  LaboratoryCamera camera = make_camera(laboratory);
  camera.open();
  ImagePool pool;
  try {
    while (true) camera.next(pool);
  } catch (const CaptureError& error) {
    EXPECT_EQ(error.fault(), CaptureFault::failed);
    EXPECT_NE(std::string(error.what()).find("beyond all bounds"), std::string::npos);
  }
}

TEST(CameraFaults, ChangeTheExposureSlowly) {
  CameraFaults faults;
  EXPECT_EQ(faults.exposure_at(3), 1);
  faults.drift = 0.2;
  faults.drift_period = 4;
  EXPECT_NEAR(faults.exposure_at(1), 1.2, 1e-12);
  EXPECT_NEAR(faults.exposure_at(3), 0.8, 1e-12);
  faults.drift_period = 4 * dt;
  Opened opened(faults);
  for (const Captured& frame : frames_of(opened.camera, 12)) {
    const double expected = 120 * faults.exposure_at(*frame.device_time);
    EXPECT_NEAR(frame.image.row(1)[0], expected, 0.51);
  }
}

TEST(CameraFaults, TearAtARowWithinTheFrame) {
  CameraFaults faults;
  for (std::int64_t k = 0; k < 1000; ++k) {
    const int row = faults.torn_row(k, 3);
    EXPECT_TRUE(row == 1 || row == 2);
  }
}

}  // namespace
}  // namespace robsim
