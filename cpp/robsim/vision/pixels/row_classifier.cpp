#include "robsim/vision/pixels/row_classifier.hpp"

#include <set>
#include <stdexcept>
#include <string>

namespace robsim::pixels {

RowClassifier::RowClassifier(const std::vector<ColorClass>& classes, int smoothing)
    : classifier_(classes), bits_(classes.size()) {
  std::set<std::string> names;
  for (const ColorClass& color : classes) {
    check_color_class(color);
    if (!names.insert(color.name).second) {
      throw std::invalid_argument("colors must have different names, got '" + color.name +
                                  "' twice");
    }
  }
  if (smoothing != 1) smoothed_.emplace(classes, smoothing);
}

void RowClassifier::begin(const ImageView& image) {
  image_ = image;
  v_ = 0;
  if (smoothed_) smoothed_->begin(image);
}

const std::vector<BitRow>& RowClassifier::next_row() {
  if (smoothed_) {
    smoothed_->next_row(bits_);
  } else {
    classifier_.classify(image_.row(v_++), image_.width, bits_);
  }
  return bits_;
}

}  // namespace robsim::pixels
