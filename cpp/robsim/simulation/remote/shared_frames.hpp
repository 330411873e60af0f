#pragma once

#include <cstddef>
#include <vector>

#include "robsim/imaging/image.hpp"

namespace robsim {

/// Frames in memory that another process writes, mapped read-only: one after the other, in slots.
/// Where there are no such mappings (Windows), making one throws std::runtime_error.
class SharedFrames {
 public:
  /// `descriptor` stays open as long as this lives. Every slot takes `slot_bytes`, a multiple of
  /// the size of a page. Throws std::system_error if it cannot be mapped.
  SharedFrames(int descriptor, int slots, std::size_t slot_bytes, int width, int height);

  /// The image in a slot: what the other process has written there. Throws std::out_of_range.
  Image image(int slot);

  /// A slot that the other process may write to while this one is looked at: one whose image
  /// nobody holds. If there is none, whoever holds that of the next slot keeps what it shows now,
  /// at the same address.
  int free_beside(int slot);

 private:
  void let_go(Image& image);

  int descriptor_;
  std::size_t slot_bytes_;
  int width_, height_;
  std::vector<Image> images_;  // empty: not mapped
};

}  // namespace robsim
