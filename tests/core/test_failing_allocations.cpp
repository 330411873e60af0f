// Every allocation of a run fails in turn: the run ends with std::bad_alloc, and goes on as if
// nothing had been.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>
#include <memory>
#include <new>
#include <numeric>
#include <vector>

#include "robsim/simulation/loop.hpp"
#include "robsim/simulation/world/simulated_world.hpp"

namespace {

constexpr std::int64_t never = std::numeric_limits<std::int64_t>::max();

thread_local std::int64_t until_failure = never;

void* allocate(std::size_t size, std::size_t alignment) {
  if (until_failure != never && until_failure-- == 0) {
    until_failure = never;  // once
    throw std::bad_alloc();
  }
  const std::size_t whole = (size / alignment + 1) * alignment;
  if (void* memory = std::aligned_alloc(alignment, whole)) return memory;
  throw std::bad_alloc();
}

// Inlined, the compiler would take it for a mistake that new ends in free.
[[gnu::noinline]] void release(void* memory) { std::free(memory); }

}  // namespace

void* operator new(std::size_t size) { return allocate(size, alignof(std::max_align_t)); }
void* operator new[](std::size_t size) { return allocate(size, alignof(std::max_align_t)); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return allocate(size, static_cast<std::size_t>(alignment));
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return allocate(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept { release(memory); }
void operator delete[](void* memory) noexcept { release(memory); }
void operator delete(void* memory, std::size_t) noexcept { release(memory); }
void operator delete[](void* memory, std::size_t) noexcept { release(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { release(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { release(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { release(memory); }
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { release(memory); }

namespace robsim {
namespace {

constexpr int steps = 5, side = 160;

void pulse(std::int64_t) {}

Layer grey_floor() {
  Image image(side, side);
  const WritableView view = image.writable_view();
  for (int v = 0; v < side; ++v) std::fill_n(view.row(v), 3 * side, std::uint8_t{120});
  return {image, image};
}

// Seen from above, it faces right: blue on its left, red on its right.
Sprite robot() {
  constexpr int size = 60;
  std::vector<std::uint8_t> rgba(4 * size * size, 0);
  for (int v = 0; v < size; ++v) {
    for (int u = 0; u < size; ++u) {
      const bool is_across = u >= 25 && u < 35;
      std::uint8_t* pixel = &rgba[4 * (size * v + u)];
      pixel[0] = is_across && v >= 45 && v < 55 ? 255 : 0;
      pixel[2] = is_across && v >= 5 && v < 15 ? 255 : 0;
      pixel[3] = 255;
    }
  }
  return premultiplied(rgba.data(), size, size);
}

std::shared_ptr<const Scene> make_scene(int headings) {
  const PlaneMap camera = PlaneMap::scaled(side, side, side, side);
  return std::make_shared<Scene>(Background(grey_floor(), grey_floor(), side / 2, 0.8),
                                 RobotImage(robot(), {29.5, 29.5}, 1, 0, headings, camera), camera);
}

// Each pixel shows in the trace, by the inputs.
double sum_of_pixels(const Frame& frame) {
  const auto view = frame.image.view();
  double sum = 0;
  for (int v = 0; v < side; ++v) sum += std::accumulate(view.row(v), view.row(v) + 3 * side, 0.0);
  return sum;
}

std::unique_ptr<Loop> make_loop(int headings) {
  WorldOptions options;
  options.area = {side, side, Boundary::bounce};
  options.camera = PlaneMap::scaled(side, side, side, side);
  options.width = options.height = side;
  options.robot_radius = 40;
  options.start = {80, 80, 0};
  options.noise = VisualNoise({5, 0});
  auto world = std::make_shared<SimulatedWorld>(options);
  world->slots().make_scene = [headings] { return make_scene(headings); };
  auto loop = std::make_unique<Loop>(
      world,
      RobotOptions{{{"red", {0, 0, 200}, {255, 255, 255}}, {"blue", {0, 200, 0}, {255, 255, 255}}},
                   MarkerLayout::across(40, 12),
                   3,
                   0},
      IdentifyFrom::measurement);
  Stages& stages = loop->stages();
  stages.define_model = [] { return RobotModel(); };
  stages.init_parameter_estimator = [](const RobotModel&) {
    return std::make_shared<RecursiveEstimator>(std::make_shared<GuardedLeastSquares>(5, 3));
  };
  stages.measure = {[](const StepPointer& step) { return step->detect(); }, false};
  stages.control = {[](const StepPointer& step) {
                      return Input{0.5 + 0.01 * static_cast<double>(step->k),
                                   0.4 + 1e-9 * sum_of_pixels(*step->look())};
                    },
                    false};
  return loop;
}

// All numbers that were recorded, missing ones as -1e9.
std::vector<double> recorded(const Loop& loop) {
  std::vector<double> numbers;
  const Trace::Snapshot snapshot = loop.trace().snapshot();
  for (const Trace::Column& column : snapshot.columns) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(snapshot.rows) * column.width(); ++i) {
      const double number = (*column.memory())[i];
      numbers.push_back(std::isnan(number) ? -1e9 : number);
    }
  }
  return numbers;
}

std::vector<double> numbers_of_a_run(int headings) {
  const auto loop = make_loop(headings);
  loop->run(steps, pulse, false);
  return recorded(*loop);
}

struct Drawing {
  int headings, stride;
};

class FailingAllocationsOf : public testing::TestWithParam<Drawing> {};

TEST_P(FailingAllocationsOf, ARunGoesOnAfterEach) {
  const std::vector<double> expected = numbers_of_a_run(GetParam().headings);
  ASSERT_GT(expected.size(), 10u * steps);
  for (std::int64_t number = 0;; number += GetParam().stride) {
    const auto loop = make_loop(GetParam().headings);
    bool has_failed = false;
    until_failure = number;
    try {
      loop->run(steps, pulse, false);
    } catch (const std::bad_alloc&) {
      has_failed = true;
    }
    until_failure = never;
    if (has_failed) loop->run(steps - loop->trace().rows(), pulse, false);
    ASSERT_EQ(recorded(*loop), expected) << "allocation " << number;
    if (!has_failed) {
      EXPECT_GT(number, 50);
      return;
    }
  }
}

// The robot's image in 36 headings is kept; in 10 000 it is too large, and made for each frame,
// with many allocations, of which each seventh fails.
INSTANTIATE_TEST_SUITE_P(Headings, FailingAllocationsOf,
                         testing::Values(Drawing{36, 1}, Drawing{10000, 7}));

TEST(FailingAllocations, NothingIsMadeOrEverything) {
  for (std::int64_t number = 0;; ++number) {
    until_failure = number;
    try {
      const auto loop = make_loop(36);
      until_failure = never;
      EXPECT_GT(number, 20);
      return;
    } catch (const std::bad_alloc&) {
      until_failure = never;
    }
  }
}

}  // namespace
}  // namespace robsim
