#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "robsim/geometry/pose.hpp"
#include "robsim/imaging/image.hpp"
#include "robsim/vision/classify.hpp"
#include "robsim/vision/smoothed_classifier.hpp"

namespace robsim {

/// A connected component (8 neighbours) of pixels of one colour class, in pixels of its frame.
struct Blob {
  std::string color;
  std::int64_t area = 0;
  Point centroid;
  PixelBox box;
  bool at_border = false;  // it touches the edge of the frame: it may go on beyond it
};

/// Per colour class the blobs, the largest first.
using BlobsByColor = std::map<std::string, std::vector<Blob>>;

struct BlobOptions {
  std::int64_t minimum_area = 12;  // px; smaller components are dropped
  int maximum_count = 64;          // of the largest blobs of a colour
  int smoothing = 1;               // px; a pixel is judged by the mean of so wide a window
};

/// Finds the blobs of every colour class in one pass over the image: rows of pixels become runs,
/// runs are joined to components by union-find, the moments are summed at the root.
/// Keeps its memory from frame to frame.
class BlobFinder {
 public:
  /// Throws std::invalid_argument for bad colour classes, two of one name, or bad options.
  explicit BlobFinder(std::vector<ColorClass> colors, const BlobOptions& options = {});

  const std::vector<ColorClass>& colors() const { return colors_; }
  BlobsByColor find(const ImageView& image);

 private:
  struct Run {
    int left;
    int right;
    std::size_t region;
  };

  struct Region {
    std::size_t parent;
    std::int64_t area;
    std::int64_t sum_u;
    std::int64_t sum_v;
    PixelBox box;
  };

  struct Components {
    std::vector<Run> above;  // the runs of the row above
    std::vector<Run> runs;
    std::vector<Region> regions;
  };

  void add_row(std::size_t color, int v, int width);
  std::vector<Blob> blobs(std::size_t color, const ImageView& image) const;

  std::vector<ColorClass> colors_;
  BlobOptions options_;
  Classifier classifier_;
  std::optional<SmoothedClassifier> smoothed_;
  std::vector<BitRow> bits_;            // per colour, of one row
  std::vector<Components> components_;  // per colour
};

}  // namespace robsim
