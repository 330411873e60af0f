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
/// complete: it is stored, or dropped if it is too small, and its slot is used again. Noise is full
/// of runs whose neighbours no processor could foresee: the loops over them have few branches.
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
    std::uint32_t slot;  // of its component, in open_
  };

  // Those of a row, from left to right: the first `count`; the others are room for more.
  template <typename T>
  struct Row {
    std::vector<T> all;
    std::size_t count = 0;

    void reserve(std::size_t most) {
      if (all.size() < most) all.resize(most);
    }
  };

  struct Open {
    Component component;
    std::uint32_t parent;  // the slot it was joined to; its own slot = root
  };

  // A run of the row above and one of this row that touch.
  struct Contact {
    std::uint32_t above;
    std::uint32_t below;
  };

  void add_held(const BitRow& below);
  void add_now(const BitRow& row, int width);
  void find_runs(const BitRow& row, int width);
  void find_contacts();
  void join_contacts();
  void close_row();
  std::uint32_t root_of(std::uint32_t i);

  std::int64_t minimum_area_ = 1;
  int v_ = 0;  // the row of runs_
  // In noise a row waits for the one below it, which tells what is isolated.
  bool is_held_ = false;
  BitRow held_, above_held_, remaining_;
  int held_width_ = 0;
  Row<Run> above_, runs_;
  Row<Contact> contacts_;
  std::vector<Open> open_;             // components of the row above and of this row, by slot
  std::vector<std::uint32_t> free_;    // slots
  std::vector<std::uint32_t> joined_;  // slots that are free when this row is done
  std::vector<Component> complete_;
};

}  // namespace robsim::pixels
