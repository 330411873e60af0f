#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "robsim/imaging/image.hpp"
#include "robsim/vision/color/color_class.hpp"
#include "robsim/vision/pixels/bit_row.hpp"
#include "robsim/vision/pixels/smoothing.hpp"

namespace robsim::light {

/// Factors on R, G and B.
using Gains = std::array<float, 3>;

/// The colour of most of an image, which is its floor: the median of each channel, on a grid.
std::array<int, 3> floor_color(const ImageView& image);

/// The gains with which a colour is grey, at most 4; 1 for one that is too dark to tell.
Gains gains_to_grey(const std::array<int, 3>& color);

/// A colour class relative to brightness: a colour belongs to it if its U - 128 and V - 128,
/// divided by the largest of R, G and B, lie within the limits. As with a saturation, light and
/// shadow do not change that.
struct RelativeClass {
  float lower[2];  // of U, V
  float upper[2];
  float darkest;  // level: what is darker is taken for so bright, as its colour drowns in noise
};

/// The class with limits as a colour class has them at full light, where a limit of 26 levels is a
/// saturation of 29 % (74 of 255); a class trained in dim light is taken for one of 26 levels. No
/// grey closer to neutral than `least_chroma` (levels) belongs to it. None for a class that limits
/// Y, or to which grey belongs.
std::optional<RelativeClass> relative_to_brightness(const ColorClass& color, float least_chroma);

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
