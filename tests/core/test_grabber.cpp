// The thread that reads a camera, with cameras that do what a script says.
#include "robsim/lab/capture/grabber.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cstring>
#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "robsim/base/system.hpp"

namespace robsim {
namespace {

constexpr double patience = 300;  // s

// A camera of small frames, each of one colour, that tells its number. `script` may throw, wait, or
// return false for a torn one.
class ScriptedDevice : public CaptureDevice {
 public:
  using Script = std::function<bool(int call)>;
  explicit ScriptedDevice(Script script) : script_(std::move(script)) {}

  void open() override {
    ++n_opened;
    if (on_open) on_open(n_opened);
  }

  std::optional<Captured> next(ImagePool& pool) override {
    const int call = n_calls++;
    Captured captured;
    captured.is_complete = script_(call);
    captured.image = pool.take(16, 16);
    std::memset(captured.image.writable_view().data, call % 251, 16 * 16 * 3);
    captured.arrived = monotonic_now();
    captured.exposed = 100 + 0.02 * call;
    return captured;
  }

  void close() noexcept override { ++n_closed; }
  void interrupt() noexcept override { is_interrupted = true; }

  std::function<void(int)> on_open;
  std::atomic<int> n_opened{0}, n_closed{0}, n_calls{0};
  std::atomic<bool> is_interrupted{false};

 private:
  Script script_;
};

[[noreturn]] void fail_with(CaptureFault fault) { throw CaptureError(fault, "scripted"); }

CaptureFault fault_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const CaptureError& error) {
    return error.fault();
  }
  throw std::logic_error("no error came");
}

// The camera delivers a frame for each permit.
struct Permits {
  std::atomic<int> n{0};
  void wait(const ScriptedDevice& device, int call) {
    while (n <= call && !device.is_interrupted) std::this_thread::yield();
  }
};

struct Stepped {
  Permits permits;
  std::shared_ptr<ScriptedDevice> device;
  explicit Stepped(std::function<bool(int)> script = [](int) { return true; }) {
    device = std::make_shared<ScriptedDevice>([this, script](int call) {
      permits.wait(*device, call);
      return script(call);
    });
  }
  void deliver(int count) {
    permits.n += count;
    while (device->n_calls <= permits.n) std::this_thread::yield();
  }
};

TEST(Grabber, AReaderGetsTheNewestFrameOnceAndItsTimeStartsAtTheFirst) {
  Stepped camera;
  Grabber grabber(camera.device, {});
  camera.deliver(5);
  const auto frame = grabber.take(patience);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->index, 4);
  EXPECT_EQ(frame->image.row(3)[5], 4);
  EXPECT_NEAR(*frame->t, 4 * 0.02, 1e-12);
  EXPECT_EQ(*frame->epoch, 100);
  EXPECT_FALSE(grabber.take(0));
  const CaptureCounts counts = grabber.counts();
  EXPECT_EQ(counts.grabbed, 5);
  EXPECT_EQ(counts.delivered, 1);
  EXPECT_EQ(counts.dropped, 4);
}

TEST(Grabber, EachNthFrameAloneIsHandedOver) {
  Stepped camera;
  GrabberOptions options;
  options.every = 3;
  Grabber grabber(camera.device, options);
  std::vector<std::int64_t> indices;
  for (int i = 0; i < 9; ++i) {
    camera.deliver(1);
    if (const auto frame = grabber.take(0)) indices.push_back(frame->index);
  }
  EXPECT_EQ(indices, (std::vector<std::int64_t>{0, 3, 6}));
  EXPECT_EQ(grabber.counts().dropped, 0);
}

TEST(Grabber, ATornFrameIsCountedAndSeenByNobody) {
  Stepped camera([](int call) { return call % 2 == 0; });
  Grabber grabber(camera.device, {});
  for (int i = 0; i < 10; ++i) {
    camera.deliver(1);
    const auto frame = grabber.take(0);
    EXPECT_EQ(frame.has_value(), i % 2 == 0);
  }
  EXPECT_EQ(grabber.counts().torn, 5);
}

TEST(Grabber, AHeldFrameDoesNotChangeAndThePoolIsBounded) {
  Stepped camera;
  Grabber grabber(camera.device, {});
  std::vector<Frame> held;
  for (int i = 0; i < 6; ++i) {
    camera.deliver(1);
    held.push_back(*grabber.take(patience));
  }
  camera.deliver(50);
  for (int i = 0; i < 6; ++i) EXPECT_EQ(held[static_cast<std::size_t>(i)].image.row(15)[47], i);
  std::set<const std::uint8_t*> places;
  for (int i = 0; i < 50; ++i) {
    camera.deliver(1);
    places.insert(grabber.take(patience)->image.row(0));
  }
  EXPECT_LE(places.size(), 4u);
}

TEST(Grabber, TheEndComesAfterTheLastFrameAndStays) {
  Stepped camera([](int call) {
    if (call == 3) fail_with(CaptureFault::end);
    return true;
  });
  Grabber grabber(camera.device, {});
  camera.permits.n = 4;
  while (camera.device->n_closed == 0) std::this_thread::yield();
  EXPECT_EQ(grabber.take(patience)->index, 2);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(fault_of([&] { grabber.take(patience); }), CaptureFault::end);
  }
}

TEST(Grabber, ACameraThatCannotBeOpenedSaysWhyAtOnceThoughItMayReopen) {
  const auto device = std::make_shared<ScriptedDevice>([](int) { return true; });
  device->on_open = [](int) { fail_with(CaptureFault::no_camera); };
  GrabberOptions options;
  options.reopen = true;
  Grabber grabber(device, options);
  EXPECT_EQ(fault_of([&] { grabber.wait_for_size(patience); }), CaptureFault::no_camera);
}

TEST(Grabber, AnUnpluggedCameraIsOpenedAgainWhenItIsBack) {
  const auto device = std::make_shared<ScriptedDevice>([](int call) {
    if (call == 2) fail_with(CaptureFault::unplugged);
    return true;
  });
  device->on_open = [](int n) {
    if (n == 2 || n == 3) fail_with(CaptureFault::no_camera);
  };
  GrabberOptions options;
  options.reopen = true;
  options.shortest_pause = 1e-4;
  Grabber grabber(device, options);
  std::optional<Frame> frame;
  do {
    frame = grabber.take(patience);
    ASSERT_TRUE(frame);
  } while (frame->index < 5);
  EXPECT_EQ(grabber.counts().reopened, 1);
  EXPECT_EQ(device->n_opened, 4);
}

TEST(Grabber, WithoutReopeningTheFaultReachesTheReader) {
  const auto device = std::make_shared<ScriptedDevice>([](int call) {
    if (call == 1) fail_with(CaptureFault::unplugged);
    return true;
  });
  Grabber grabber(device, {});
  EXPECT_TRUE(grabber.take(patience));
  EXPECT_EQ(fault_of([&] { grabber.take(patience); }), CaptureFault::unplugged);
}

TEST(Grabber, TimeOutsAreCountedAndThreeInARowReopen) {
  const auto device = std::make_shared<ScriptedDevice>([](int call) {
    if (call >= 1 && call < 4) fail_with(CaptureFault::time_out);
    return true;
  });
  GrabberOptions options;
  options.reopen = true;
  options.shortest_pause = 1e-4;
  Grabber grabber(device, options);
  while (grabber.counts().grabbed < 3) std::this_thread::yield();
  EXPECT_EQ(grabber.counts().timeouts, 3);
  EXPECT_EQ(grabber.counts().reopened, 1);
}

TEST(Grabber, AFrameOfAnotherSizeEndsIt) {
  GrabberOptions options;
  options.size = {32, 16};
  Grabber grabber(std::make_shared<ScriptedDevice>([](int) { return true; }), options);
  EXPECT_EQ(fault_of([&] { grabber.take(patience); }), CaptureFault::failed);
}

TEST(Grabber, ACloseWhileAReaderWaitsEndsItsWait) {
  Stepped camera;
  Grabber grabber(camera.device, {});
  std::thread closer([&] { grabber.close(); });
  EXPECT_THROW(while (true) grabber.take(patience), std::invalid_argument);
  closer.join();
  EXPECT_THROW(grabber.take(0), std::invalid_argument);
  EXPECT_EQ(camera.device->n_closed, 1);
  grabber.close();
}

TEST(Grabber, ADeviceThatHangsIsLeftBehindAndItsThreadEndsWithTheCall) {
  std::atomic<bool> hangs{true};
  std::weak_ptr<ScriptedDevice> left;
  {
    const auto device = std::make_shared<ScriptedDevice>([&](int) {
      while (hangs) std::this_thread::yield();
      return true;
    });
    left = device;
    Grabber grabber(device, {});
    while (device->n_calls == 0) std::this_thread::yield();
    grabber.close(0.01);
  }
  EXPECT_FALSE(left.expired());
  hangs = false;
  while (!left.expired()) std::this_thread::yield();
}

TEST(Grabber, ALongStreamBetweenTwoThreadsLosesCountOfNothing) {
  constexpr int many = 20000;
  const auto device = std::make_shared<ScriptedDevice>([](int call) {
    if (call == many) fail_with(CaptureFault::end);
    return call % 7 != 0;
  });
  Grabber grabber(device, {});
  std::int64_t last = -1;
  std::int64_t taken = 0;
  const auto read = [&] {
    while (true) {
      const auto frame = grabber.take(patience);
      ASSERT_TRUE(frame);
      EXPECT_GT(frame->index, last);
      EXPECT_NE(frame->index % 7, 0);
      for (int v = 0; v < 16; ++v) EXPECT_EQ(frame->image.row(v)[47], frame->index % 251);
      last = frame->index;
      ++taken;
    }
  };
  EXPECT_EQ(fault_of(read), CaptureFault::end);
  const CaptureCounts counts = grabber.counts();
  EXPECT_EQ(counts.grabbed + counts.torn, many);
  EXPECT_EQ(counts.delivered, taken);
  EXPECT_EQ(counts.delivered + counts.dropped, counts.grabbed);
}

}  // namespace
}  // namespace robsim
