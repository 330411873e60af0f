#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "robsim/imaging/image.hpp"
#include "robsim/vision/color/color_class.hpp"
#include "robsim/vision/pixels/bit_row.hpp"
#include "robsim/vision/pixels/classify.hpp"
#include "robsim/vision/pixels/smoothing.hpp"

namespace robsim::pixels {

/// Decides which pixels belong to which class by the mean of the window of pixels around them, in
/// every channel that a class limits. Beyond the border of the image its outermost pixels are
/// repeated. Where the window contains grey pixels only, no mean is computed.
class SmoothedClassifier {
 public:
  static constexpr int maximum_window = 15;

  /// Throws std::invalid_argument unless the window is 3, 5, ... 15 px wide.
  SmoothedClassifier(const std::vector<ColorClass>& classes, int window);

  /// Starts an image, which must not change until its last row is done.
  void begin(const ImageView& image);

  /// Sets, for each class, the bits of the next row.
  void next_row(std::vector<BitRow>& bits);

 private:
  struct Channel {
    bool is_needed = false;
    std::vector<std::uint8_t> rows;        // a ring of the newest ones
    std::vector<WindowSums::Sum> columns;  // sums over the rows of the window, with margins
    std::vector<WindowSums::Sum> sums;     // over the windows around the pixels of the current row
  };

  // A bit for each block of 64 pixels of a row
  using Blocks = BitRow;

  int blocks() const { return static_cast<int>(words_); }
  Blocks& may_contain(int v);
  std::uint8_t* row(Channel& channel, int v);
  WindowSums::Sum* column(Channel& channel, std::size_t u);
  int clamped(int v) const;
  void screen_row(int v);
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
  std::size_t words_ = 0;            // blocks of 64 pixels per row
  int v_ = 0;                        // the current row
  int unscreened_rows_ = 0;          // how many of the newest rows may contain members everywhere
  int grey_rows_ = 0;                // how many of them contain none
  std::vector<Blocks> may_contain_;  // a ring of the newest rows
  Blocks candidates_;                // a row of the window may contain a member
  Blocks active_;                    // the means must be computed
  Blocks is_summed_, was_summed_;    // the column sums are valid for row v_, for the row above it
  Blocks continued_, begun_;         // they are moved down from the row above, or summed anew
};

/// Decides, row by row, which pixels of an image belong to which class: by their own colour or,
/// with smoothing, by the mean of the window around them.
class RowClassifier {
 public:
  /// Throws std::invalid_argument for invalid classes, duplicate names, too many classes, and
  /// unless smoothing is 1 (off) or a window of 3, 5, ... 15 px.
  RowClassifier(const std::vector<ColorClass>& classes, int smoothing);

  /// Starts an image, which must not change until its last row is done.
  void begin(const ImageView& image);

  /// Returns, for each class, the bits of the next row.
  const std::vector<BitRow>& next_row();

 private:
  Classifier classifier_;
  std::optional<SmoothedClassifier> smoothed_;
  ImageView image_;
  int v_ = 0;
  std::vector<BitRow> bits_;
};

}  // namespace robsim::pixels
