#include "robsim/vision/find_blobs.hpp"

#include <algorithm>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace robsim {

namespace {

PixelBox moved(const PixelBox& box, int u, int v) {
  return {box.left + u, box.top + v, box.right + u, box.bottom + v};
}

}  // namespace

BlobFinder::BlobFinder(std::vector<ColorClass> colors, const BlobOptions& options)
    : colors_(std::move(colors)),
      options_(options),
      classifier_(colors_, options.smoothing),
      components_(colors_.size()) {
  if (options.minimum_area < 1) {
    throw std::invalid_argument("minimum_area must be at least 1 px, got " +
                                std::to_string(options.minimum_area));
  }
  if (options.maximum_count < 1) {
    throw std::invalid_argument("maximum_count must be at least 1, got " +
                                std::to_string(options.maximum_count));
  }
}

BlobsByColor BlobFinder::find(const ImageView& image, const PixelBox& part) {
  check_region(part, image);
  const ImageView view{image.row(part.top) + std::ptrdiff_t{3} * part.left, part.right - part.left,
                       part.bottom - part.top, image.stride};
  for (pixels::ComponentFinder& components : components_) components.begin(options_.minimum_area);
  classifier_.begin(view);
  for (int v = 0; v < view.height; ++v) {
    const std::vector<pixels::BitRow>& bits = classifier_.next_row();
    for (std::size_t i = 0; i < colors_.size(); ++i) components_[i].add_row(bits[i], view.width);
  }
  BlobsByColor found;
  for (std::size_t i = 0; i < colors_.size(); ++i) found[colors_[i].name] = blobs(i, part);
  return found;
}

std::vector<Blob> BlobFinder::blobs(std::size_t color, const PixelBox& part) {
  std::vector<pixels::Component> largest = components_[color].finish();
  const auto count = std::min(largest.size(), static_cast<std::size_t>(options_.maximum_count));
  const auto is_larger = [](const pixels::Component& a, const pixels::Component& b) {
    return std::make_tuple(-a.area, a.box.top, a.box.left) <
           std::make_tuple(-b.area, b.box.top, b.box.left);
  };
  std::partial_sort(largest.begin(), largest.begin() + static_cast<std::ptrdiff_t>(count),
                    largest.end(), is_larger);
  largest.resize(count);
  std::vector<Blob> blobs;
  for (const pixels::Component& c : largest) {
    const auto area = static_cast<double>(c.area);
    const PixelBox box = moved(c.box, part.left, part.top);
    const bool at_border = box.left == part.left || box.top == part.top ||
                           box.right == part.right || box.bottom == part.bottom;
    const Point centroid{part.left + static_cast<double>(c.sum_u) / area,
                         part.top + static_cast<double>(c.sum_v) / area};
    blobs.push_back({colors_[color].name, c.area, centroid, box, at_border});
  }
  return blobs;
}

}  // namespace robsim
