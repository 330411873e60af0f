#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "robsim/base/geometry.hpp"
#include "robsim/imaging/image.hpp"

namespace robsim {

/// The image made smaller by whole factors, each pixel the mean of a block, until another factor
/// would make it narrower than `width`; what a factor leaves over at the right and below is
/// dropped. The same pixels where nothing is to be done.
Image reduced(const Image& image, int width);

/// Makes an image from another one, each pixel at a place of its own there: bilinear, to 1/256 px.
/// What lies outside is grey.
class Warp {
 public:
  /// `to_source` gives the place in the source, of source_width x source_height px, for a pixel of
  /// an image of width x height px. It is asked once for each. Throws std::invalid_argument unless
  /// the source has a width and a height of 2..65534 px.
  Warp(int width, int height, int source_width, int source_height,
       const std::function<Point(const Point&)>& to_source);

  int width() const { return width_; }
  int height() const { return height_; }

  /// Throws std::invalid_argument unless both images have their sizes.
  void apply(const ImageView& source, const WritableView& to) const;

  /// Lays something over an image, given how it looks, in `box` of the source, before black and
  /// before white. Throws as `apply`.
  void lay_over(const ImageView& before_black, const ImageView& before_white, const PixelBox& box,
                const WritableView& to) const;

 private:
  // A place: the pixel to its upper left, and how far it is from there (1/256 px).
  struct Place {
    std::uint16_t u, v;
    std::uint16_t right, down;
  };

  Place place_of(const Point& point) const;
  void check_sizes(const ImageView& source, const WritableView& to) const;
  static std::uint64_t color_at(const ImageView& source, const Place& place);

  int width_, height_;
  int source_width_, source_height_;
  std::vector<Place> places_;
};

}  // namespace robsim
