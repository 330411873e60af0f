#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "robsim/imaging/image.hpp"
#include "robsim/vision/pixels/bit_row.hpp"

namespace robsim {

/// The moments of a connected set of pixels.
struct Component {
  std::int64_t area = 0;
  std::int64_t sum_u = 0;
  std::int64_t sum_v = 0;
  PixelBox box;
};

/// Joins the set pixels of an image to components (8 neighbours), row by row: the runs of a row
/// are joined with those of the row above by union-find. Only components that the newest row
/// touches are kept in reach; the others are complete, and too small ones are dropped at once.
class ComponentFinder {
 public:
  /// Forgets all; components below this area will be dropped.
  void begin(std::int64_t minimum_area);

  /// The next row from above.
  void add_row(const BitRow& row, int width);

  /// The components, once all rows are there.
  const std::vector<Component>& finish();

 private:
  struct Run {
    int left;
    int right;
    std::uint32_t component;  // its place in open_
  };

  struct Open {
    Component component;
    std::uint32_t parent;  // the one it was joined to, or its own place
  };

  std::uint32_t root_of(std::uint32_t i);
  void join(std::uint32_t a, std::uint32_t b);
  void add_run(int left, int right, std::size_t& first_above);
  void close_row();

  std::int64_t minimum_area_ = 1;
  int v_ = 0;
  std::vector<Run> above_;  // the runs of the row above
  std::vector<Run> runs_;
  std::vector<Open> open_;  // those of the runs above, and of this row
  std::vector<Open> still_open_;
  std::vector<std::uint32_t> place_;  // in still_open_
  std::vector<Component> complete_;
};

}  // namespace robsim
