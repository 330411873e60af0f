#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "robsim/imaging/image.hpp"
#include "robsim/vision/color/color_class.hpp"
#include "robsim/vision/pixels/bit_row.hpp"
#include "robsim/vision/pixels/chroma_screen.hpp"
#include "robsim/vision/pixels/window_sums.hpp"

namespace robsim {

/// Tells which pixels belong to which class by the mean of the window of pixels around them, in
/// every channel that a class limits. Beyond the border of the image its outermost pixels go on.
/// Where the window holds grey pixels only, no mean is worked out.
class SmoothedClassifier {
 public:
  static constexpr int largest_window = 15;

  /// Throws std::invalid_argument unless the window is 3, 5, ... 15 px wide.
  SmoothedClassifier(const std::vector<ColorClass>& classes, int window);

  /// Begins with an image, which must stay as it is until its last row.
  void begin(const ImageView& image);

  /// Sets, for each class, the bits of the next row.
  void next_row(std::vector<BitRow>& bits);

 private:
  struct Channel {
    bool is_needed = false;
    std::vector<std::uint8_t> rows;        // the newest ones, in turns
    std::vector<WindowSums::Sum> columns;  // sums of the window's rows, with a margin on both sides
  };

  // A flag for each 64 pixels of a row
  using Flags = std::vector<std::uint8_t>;

  Flags& may_hold(int v);
  std::uint8_t* row(Channel& channel, int v);
  WindowSums::Sum* column(Channel& channel, std::size_t u);
  int within(int v) const;
  void look(int v);
  void move_suspects_down();
  void find_active();
  void classify_active(std::vector<BitRow>& bits);
  void convert(int v, std::size_t first, std::size_t last);
  void fill(std::size_t first, std::size_t last);
  void move_down(std::size_t first, std::size_t last);
  void classify(std::size_t first, std::size_t last, std::vector<BitRow>& bits);

  int window_;
  std::vector<std::vector<WindowSums::Limits>> limits_;  // per class
  ChromaScreen screen_;
  Channel channels_[3];
  ImageView image_;
  std::size_t words_ = 0;         // 64 pixels each
  int v_ = 0;                     // the row at hand
  int colorful_rows_ = 0;         // the newest ones that may hold members everywhere
  std::vector<Flags> may_hold_;   // a member, of the newest rows, in turns
  Flags suspects_;                // how many rows of the window may hold one
  Flags active_;                  // the means decide
  Flags is_summed_, was_summed_;  // the sums of the columns are those of row v, of the row above
};

}  // namespace robsim
