#pragma once

#include <optional>
#include <vector>

#include "robsim/imaging/image.hpp"
#include "robsim/vision/pixels/classify.hpp"
#include "robsim/vision/pixels/smoothed_classifier.hpp"

namespace robsim::pixels {

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
