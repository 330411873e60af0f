#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "robsim/imaging/image.hpp"
#include "robsim/vision/light/relative_class.hpp"
#include "robsim/vision/light/white.hpp"
#include "robsim/vision/pixels/bit_row.hpp"
#include "robsim/vision/pixels/window_sums.hpp"

namespace robsim::light {

/// Decides, row by row, which pixels of an image belong to which class relative to brightness, by
/// the mean of the window of pixels around them. Beyond the border of the image its outermost
/// pixels are repeated.
class RelativeClassifier {
 public:
  /// A class that is missing has no pixels. `window` is 1 = off, 3, 5, ... 15 px. The image must
  /// not change until its last row is done.
  RelativeClassifier(const ImageView& image, std::vector<std::optional<RelativeClass>> classes,
                     int window, const Gains& gains);

  /// Returns, for each class, the bits of the next row.
  const std::vector<pixels::BitRow>& next_row();

 private:
  using Sum = pixels::WindowSums::Sum;

  const std::uint8_t* row(int v) const;
  void exchange(const std::uint8_t* in, const std::uint8_t* out);

  ImageView image_;
  std::vector<std::optional<RelativeClass>> classes_;
  int window_;
  Gains factors_;  // from the sum over a window to a balanced mean
  int v_ = 0;
  std::vector<Sum> columns_;  // R, G, B sums over the rows of the window, with margins
  std::vector<Sum> sums_;     // over the window
  std::vector<float> chroma_[2];
  std::vector<float> brightness_;
  std::vector<pixels::BitRow> bits_;
};

}  // namespace robsim::light
