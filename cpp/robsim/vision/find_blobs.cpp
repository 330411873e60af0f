#include "robsim/vision/find_blobs.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "robsim/base/system.hpp"

namespace robsim {

namespace {

PixelBox moved(const PixelBox& box, int u, int v) {
  return {box.left + u, box.top + v, box.right + u, box.bottom + v};
}

std::vector<std::string> names_of(const std::vector<ColorClass>& colors) {
  std::vector<std::string> names;
  for (const ColorClass& color : colors) names.push_back(color.name);
  return names;
}

}  // namespace

BlobCollector::BlobCollector(std::vector<std::string> names, const BlobOptions& options)
    : names_(std::move(names)),
      minimum_area_(options.minimum_area),
      maximum_count_(static_cast<std::size_t>(options.maximum_count)),
      components_(names_.size()) {
  checked(options.minimum_area, options.minimum_area >= 1, "minimum_area must be at least 1 px");
  checked(options.maximum_count, options.maximum_count >= 1, "maximum_count must be at least 1");
}

void BlobCollector::begin(const PixelBox& part) {
  part_ = part;
  for (pixels::ComponentFinder& components : components_) components.begin(minimum_area_);
}

void BlobCollector::add_row(const std::vector<pixels::BitRow>& bits) {
  const int width = part_.right - part_.left;
  for (std::size_t i = 0; i < names_.size(); ++i) components_[i].add_row(bits[i], width);
}

BlobsByColor BlobCollector::finish() {
  BlobsByColor found;
  for (std::size_t i = 0; i < names_.size(); ++i) found[names_[i]] = blobs(i);
  return found;
}

std::vector<Blob> BlobCollector::blobs(std::size_t color) {
  std::vector<pixels::Component> largest = components_[color].finish();
  const auto count = std::min(largest.size(), maximum_count_);
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
    const PixelBox box = moved(c.box, part_.left, part_.top);
    const bool at_border = box.left == part_.left || box.top == part_.top ||
                           box.right == part_.right || box.bottom == part_.bottom;
    const Point centroid{part_.left + static_cast<double>(c.sum_u) / area,
                         part_.top + static_cast<double>(c.sum_v) / area};
    blobs.push_back({names_[color], c.area, centroid, box, at_border});
  }
  return blobs;
}

BlobFinder::BlobFinder(std::vector<ColorClass> colors, const BlobOptions& options)
    : colors_(std::move(colors)),
      options_(options),
      classifier_(colors_, options.smoothing),
      collector_(names_of(colors_), options) {}

BlobsByColor BlobFinder::find(const ImageView& image, const PixelBox& part) {
  check_region(part, image);
  const ImageView view{image.row(part.top) + std::ptrdiff_t{3} * part.left, part.right - part.left,
                       part.bottom - part.top, image.stride};
  collector_.begin(part);
  classifier_.begin(view);
  for (int v = 0; v < view.height; ++v) collector_.add_row(classifier_.next_row());
  return collector_.finish();
}

}  // namespace robsim
