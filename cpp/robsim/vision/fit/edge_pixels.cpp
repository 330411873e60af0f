#include "robsim/vision/fit/edge_pixels.hpp"

#include <algorithm>
#include <cmath>

#include "robsim/base/elementary/elementary.hpp"
#include "robsim/base/simd/cpu_path.hpp"
#include "robsim/base/simd/lanes.hpp"
#include "robsim/base/simd/target.hpp"

namespace robsim::fit {

namespace {

// What a marker may take at most, so that time and memory are bounded whatever its outline is.
constexpr int most_side = 1 << 14;     // of the box around it (px)
constexpr int most_in_box = 1 << 24;   // px
constexpr int most_at_edge = 1 << 18;  // px

struct Placed {
  Pose pose;
  double sin, cos;

  explicit Placed(const Pose& at) : pose(at) {
    const auto [s, c] = elementary::sin_cos(at.heading);
    sin = s;
    cos = c;
  }
  Point to_robot(const Point& world) const {
    const double x = world.x - pose.x;
    const double y = world.y - pose.y;
    return {x * cos + y * sin, -x * sin + y * cos};
  }
  Point to_world(const Point& robot) const {
    return {pose.x + robot.x * cos - robot.y * sin, pose.y + robot.x * sin + robot.y * cos};
  }
};

// From pixels of a box to the robot's frame, to second order: exact for the camera that looks
// straight down, and within 1e-4 px of the marker of a tilted one with a lens.
class LocalMap {
 public:
  LocalMap(const PlaneMap& map, const Placed& robot, const PixelBox& box)
      : u_((box.left + box.right - 1) / 2.0), v_((box.top + box.bottom - 1) / 2.0) {
    const double a = std::max(1.0, (box.right - box.left) / 2.0);
    const double b = std::max(1.0, (box.bottom - box.top) / 2.0);
    const auto at = [&](int i, int j) {
      return robot.to_robot(map.to_world({u_ + i * a, v_ + j * b}));
    };
    const Point middle = at(0, 0), left = at(-1, 0), right = at(1, 0), top = at(0, -1),
                bottom = at(0, 1);
    const Point corners[4] = {at(-1, -1), at(1, -1), at(-1, 1), at(1, 1)};
    for (const auto part : {&Point::x, &Point::y}) {
      Coefficients& c = part == &Point::x ? x_ : y_;
      c.constant = middle.*part;
      c.u = (right.*part - left.*part) / (2 * a);
      c.v = (bottom.*part - top.*part) / (2 * b);
      c.uu = (right.*part + left.*part - 2 * c.constant) / (2 * a * a);
      c.vv = (bottom.*part + top.*part - 2 * c.constant) / (2 * b * b);
      c.uv =
          (corners[0].*part - corners[1].*part - corners[2].*part + corners[3].*part) / (4 * a * b);
    }
  }

  /// The coefficients of x and y in a row, as polynomials of the column from `middle`.
  void row(int v, float (&x)[3], float (&y)[3]) const {
    x_.in_row(v - v_, x);
    y_.in_row(v - v_, y);
  }
  double middle() const { return u_; }

 private:
  struct Coefficients {
    double constant, u, v, uu, uv, vv;
    void in_row(double b, float (&polynomial)[3]) const {
      polynomial[0] = static_cast<float>(constant + b * (v + b * vv));
      polynomial[1] = static_cast<float>(u + b * uv);
      polynomial[2] = static_cast<float>(uu);
    }
  };

  double u_, v_;
  Coefficients x_, y_;
};

// The pixels that the marker and so many frame px around it take; empty if the map does not show
// it, or if they are too many.
PixelBox box_around(const ImageView& image, const PlaneMap& map, const MarkerShape& shape,
                    const Placed& robot, double margin) {
  Point least{1e9, 1e9};
  Point most{-1e9, -1e9};
  for (const Point& corner : shape.polygon()) {
    const Point pixel = map.to_pixel(robot.to_world(corner));
    if (!(std::fabs(pixel.x) < 1e8 && std::fabs(pixel.y) < 1e8)) return {};
    least = {std::min(least.x, pixel.x), std::min(least.y, pixel.y)};
    most = {std::max(most.x, pixel.x), std::max(most.y, pixel.y)};
  }
  const PixelBox box{static_cast<int>(std::floor(least.x - margin)),
                     static_cast<int>(std::floor(least.y - margin)),
                     static_cast<int>(std::ceil(most.x + margin)) + 1,
                     static_cast<int>(std::ceil(most.y + margin)) + 1};
  if (box.right - box.left > most_side || box.bottom - box.top > most_side) return {};
  const PixelBox seen = intersection(box, {0, 0, image.width, image.height});
  const bool is_large =
      !seen.empty() && seen.right - seen.left > most_in_box / (seen.bottom - seen.top);
  return is_large ? PixelBox{} : seen;
}

using simd::HalvedLanesOf;
using simd::LanesOf;
using Cell = MarkerShape::Table::Cell;

// Pixels next to each other in a row: where they are in the robot's frame, and in the table.
struct Run {
  static constexpr int size = 8;

  float x[size], y[size];          // work-area px, from the robot's centre
  std::int32_t cell[size];         // of the table
  float across[size], down[size];  // from its middle (work-area px)
};

struct RowMap {
  float x[3], y[3];  // coefficients of the column, from the middle of the box
  float left, top;   // of the table (work-area px)
  float per_px;      // its cells
};

// `start`: the first column, from the middle of the box.
template <typename Floats>
ROBSIM_INLINE void look_up(const RowMap& map, float start, std::vector<Run>& runs) {
  constexpr int cells = MarkerShape::Table::cells;
  constexpr float columns[Run::size] = {0, 1, 2, 3, 4, 5, 6, 7};
  static_assert(Run::size == Floats::count);
  const Floats last = Floats::all(cells - 0.001F);
  const float width = 1 / map.per_px;
  for (Run& run : runs) {
    const Floats a = Floats::all(start) + Floats::load(columns);
    const Floats x =
        Floats::all(map.x[0]) + a * (Floats::all(map.x[1]) + a * Floats::all(map.x[2]));
    const Floats y =
        Floats::all(map.y[0]) + a * (Floats::all(map.y[1]) + a * Floats::all(map.y[2]));
    x.store(run.x);
    y.store(run.y);
    // NaN becomes 0
    within((x - Floats::all(map.left)) * Floats::all(map.per_px), Floats::all(0), last)
        .store(run.across);
    within((y - Floats::all(map.top)) * Floats::all(map.per_px), Floats::all(0), last)
        .store(run.down);
    for (int i = 0; i < Run::size; ++i) {
      const auto column = static_cast<std::int32_t>(run.across[i]);
      const auto row = static_cast<std::int32_t>(run.down[i]);
      run.cell[i] = row * cells + column;
      run.across[i] = (run.across[i] - static_cast<float>(column) - 0.5F) * width;
      run.down[i] = (run.down[i] - static_cast<float>(row) - 0.5F) * width;
    }
    start += Run::size;
  }
}

// A pixel of a row that lies in the ring.
struct Place {
  std::int32_t column;  // from the left of the box
  float distance;       // from the edge (work-area px)
};

// Writes those of the first `count` pixels whose distance is in [outside, inside], and returns how
// many. Without a branch, which no processor could foresee.
int in_ring(const MarkerShape::Table& table, const std::vector<Run>& runs, int count, float outside,
            float inside, std::vector<Place>& places) {
  int found = 0;
  Place* place = places.data();
  for (int left = 0; left < count; left += Run::size) {
    const Run& run = runs[static_cast<std::size_t>(left / Run::size)];
    for (int k = 0; k < std::min(Run::size, count - left); ++k) {
      const Cell& cell = table.data()[run.cell[k]];
      const float distance =
          cell.distance + cell.slope_x * run.across[k] + cell.slope_y * run.down[k];
      place[found] = {left + k, distance};
      found += static_cast<int>(distance >= outside) & static_cast<int>(distance <= inside);
    }
  }
  return found;
}

void add(EdgePixels& pixels, float distance, const Cell& cell, float x, float y,
         const std::uint8_t* rgb, int place) {
  const auto [block, k] = pixels.next();
  block->distance[k] = distance;
  block->normal_x[k] = cell.slope_x;
  block->normal_y[k] = cell.slope_y;
  // d distance / d heading = normal . (y, -x)
  block->turn[k] = cell.slope_x * y - cell.slope_y * x;
  for (int c = 0; c < 3; ++c) block->color[c][k] = static_cast<float>(rgb[c]) - EdgePixels::grey;
  block->weight[k] = 1;
  block->place[k] = place;
}

}  // namespace

std::pair<EdgeBlock*, int> EdgePixels::next() {
  if (count % EdgeBlock::size == 0) blocks.emplace_back();  // all zero
  return {&blocks.back(), count++ % EdgeBlock::size};
}

void EdgePixels::add(const EdgeBlock& from, int i) {
  const auto [block, k] = next();
  block->distance[k] = from.distance[i];
  block->normal_x[k] = from.normal_x[i];
  block->normal_y[k] = from.normal_y[i];
  block->turn[k] = from.turn[i];
  for (int c = 0; c < 3; ++c) block->color[c][k] = from.color[c][i];
  block->weight[k] = from.weight[i];
  block->place[k] = from.place[i];
}

void gather(const ImageView& image, const PlaneMap& map, const MarkerShape& shape, const Pose& pose,
            const Ring& ring, EdgePixels& pixels) {
  pixels.blocks.clear();
  pixels.count = 0;
  const Placed robot(pose);
  const PixelBox box = box_around(image, map, shape, robot, ring.outside + 1);
  const int width = box.right - box.left;
  pixels.left = box.left;
  pixels.top = box.top;
  pixels.stride = width + EdgePixels::gap;
  pixels.height = box.bottom - box.top;
  const Point centre = map.to_pixel(robot.to_world(shape.centroid()));
  pixels.scale = 1 / std::sqrt(map.area_scale(centre));
  if (box.empty() || !std::isfinite(pixels.scale)) return;
  const LocalMap to_robot(map, robot, box);
  const MarkerShape::Table& table = shape.table();
  RowMap row_map;
  row_map.left = static_cast<float>(table.left());
  row_map.top = static_cast<float>(table.top());
  row_map.per_px = static_cast<float>(table.per_px());
  // Places beyond the table lie further outside than the ring, but if a marker is of a pixel or
  // two.
  const auto outside = static_cast<float>(-ring.outside / pixels.scale);
  const auto inside = static_cast<float>(ring.inside / pixels.scale);
  std::vector<Run> runs(static_cast<std::size_t>((width + Run::size - 1) / Run::size));
  std::vector<Place> places(static_cast<std::size_t>(width));
  for (int j = 0; j < pixels.height; ++j) {
    const int v = box.top + j;
    to_robot.row(v, row_map.x, row_map.y);
    ROBSIM_PICK(look_up<HalvedLanesOf<float>>, look_up<LanesOf<float>>)
    (row_map, static_cast<float>(box.left - to_robot.middle()), runs);
    const std::uint8_t* row = image.row(v) + std::ptrdiff_t{3} * box.left;
    const int count = in_ring(table, runs, width, outside, inside, places);
    if (pixels.count + count > most_at_edge) {
      pixels.blocks.clear();
      pixels.count = 0;
      return;
    }
    for (int n = 0; n < count; ++n) {
      const auto [i, distance] = places[static_cast<std::size_t>(n)];
      const Run& run = runs[static_cast<std::size_t>(i / Run::size)];
      const int k = i % Run::size;
      add(pixels, distance, table.data()[run.cell[k]], run.x[k], run.y[k],
          row + std::ptrdiff_t{3} * i, j * pixels.stride + i);
    }
  }
}

}  // namespace robsim::fit
