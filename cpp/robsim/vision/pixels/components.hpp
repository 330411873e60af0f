#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "robsim/imaging/image.hpp"
#include "robsim/vision/pixels/bit_row.hpp"

namespace robsim::pixels {

/// The moments of a connected set of pixels.
struct Component {
  std::int64_t area = 0;
  std::int64_t sum_u = 0;
  std::int64_t sum_v = 0;
  PixelBox box;
};

/// Connected components (8 neighbours) of the set pixels of an image, row by row: union-find joins
/// the runs of a row with those of the row above. A component that the newest row does not touch is
/// complete: it is stored, or dropped if it is too small, and its slot is used again.
class ComponentFinder {
 public:
  /// Starts a new image; components of a smaller area will be dropped.
  void begin(std::int64_t minimum_area);

  /// Adds the next row, from top to bottom.
  void add_row(const BitRow& row, int width);

  /// Returns the components. Call it after the last row.
  const std::vector<Component>& finish();

 private:
  struct Run {
    int left;
    int right;
    std::uint32_t component;  // its slot in open_
  };

  struct Open {
    Component component;
    std::uint32_t parent;  // the slot it was joined to; its own slot = root
  };

  std::uint32_t root_of(std::uint32_t i);
  void join(std::uint32_t a, std::uint32_t b);
  void add_run(int left, int right, std::size_t& first_above);
  void close_row();

  std::int64_t minimum_area_ = 1;
  int v_ = 0;
  std::vector<Run> above_;  // the runs of the row above
  std::vector<Run> runs_;
  std::vector<Open> open_;  // components of the row above and of this row, by slot
  std::vector<Open> next_open_;
  std::vector<std::uint32_t> new_slot_;  // in next_open_, of each root in open_
  std::vector<Component> complete_;
};

}  // namespace robsim::pixels
