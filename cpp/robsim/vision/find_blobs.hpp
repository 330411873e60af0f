#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "robsim/base/geometry.hpp"
#include "robsim/imaging/image.hpp"
#include "robsim/vision/pixels/components.hpp"
#include "robsim/vision/pixels/row_classifier.hpp"

namespace robsim {

/// A connected component (8 neighbours) of pixels of one colour class, in pixels of its frame.
struct Blob {
  std::string color;
  std::int64_t area = 0;
  Point centroid;
  PixelBox box;
  bool at_border = false;  // it touches the edge of the frame and may continue beyond it
};

/// Per colour class the blobs, the largest first.
using BlobsByColor = std::map<std::string, std::vector<Blob>>;

struct BlobOptions {
  std::int64_t minimum_area = 12;  // px; smaller components are dropped
  int maximum_count = 64;          // of the largest blobs of a colour
  int smoothing = 1;               // px; width of the window whose mean classifies a pixel, 1 = off

  bool operator==(const BlobOptions& other) const {
    return minimum_area == other.minimum_area && maximum_count == other.maximum_count &&
           smoothing == other.smoothing;
  }
};

/// Makes blobs of rows of bits, which say which pixel has which colour: bits become runs, runs are
/// joined to components. Its buffers are reused from part to part.
class BlobCollector {
 public:
  /// The largest blobs of each of these colours. Throws std::invalid_argument for invalid options.
  BlobCollector(std::vector<std::string> names, const BlobOptions& options);

  /// Starts a part of an image.
  void begin(const PixelBox& part);

  /// Adds the next row of the part, its bits per colour, from top to bottom.
  void add_row(const std::vector<pixels::BitRow>& bits);

  /// Returns the blobs, in pixels of the whole image. Call it after the last row.
  BlobsByColor finish();

 private:
  std::vector<Blob> blobs(std::size_t color);

  std::vector<std::string> names_;
  std::int64_t minimum_area_;
  std::size_t maximum_count_;
  PixelBox part_;
  std::vector<pixels::ComponentFinder> components_;  // per colour
};

/// Finds the blobs of every colour class in one pass over the image: rows of pixels become bits,
/// bits become blobs.
/// Its buffers are reused from frame to frame.
class BlobFinder {
 public:
  /// Throws std::invalid_argument for invalid colour classes, duplicate names or invalid options.
  explicit BlobFinder(std::vector<ColorClass> colors, const BlobOptions& options = {});

  const std::vector<ColorClass>& colors() const { return colors_; }
  const BlobOptions& options() const { return options_; }

  BlobsByColor find(const ImageView& image) {
    return find(image, {0, 0, image.width, image.height});
  }

  /// Searches a part of the image only, as if the image ended there; positions are those in the
  /// whole image. Throws std::invalid_argument unless the part lies within it and is not empty.
  BlobsByColor find(const ImageView& image, const PixelBox& part);

 private:
  std::vector<ColorClass> colors_;
  BlobOptions options_;
  pixels::RowClassifier classifier_;
  BlobCollector collector_;
};

}  // namespace robsim
