#include "robsim/vision/find_blobs.hpp"

#include <algorithm>
#include <set>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace robsim {

namespace {

template <typename Regions>
std::size_t root_of(Regions& regions, std::size_t i) {
  while (regions[i].parent != i) {
    regions[i].parent = regions[regions[i].parent].parent;
    i = regions[i].parent;
  }
  return i;
}

template <typename Regions>
std::size_t join(Regions& regions, std::size_t i, std::size_t j) {
  i = root_of(regions, i);
  j = root_of(regions, j);
  if (i == j) return i;
  auto& a = regions[i];
  const auto& b = regions[j];
  a.area += b.area;
  a.sum_u += b.sum_u;
  a.sum_v += b.sum_v;
  a.box = {std::min(a.box.left, b.box.left), std::min(a.box.top, b.box.top),
           std::max(a.box.right, b.box.right), std::max(a.box.bottom, b.box.bottom)};
  regions[j].parent = i;
  return i;
}

}  // namespace

BlobFinder::BlobFinder(std::vector<ColorClass> colors, const BlobOptions& options)
    : colors_(std::move(colors)),
      options_(options),
      classifier_(colors_),
      bits_(colors_.size()),
      components_(colors_.size()) {
  std::set<std::string> names;
  for (const ColorClass& color : colors_) {
    check_color_class(color);
    if (!names.insert(color.name).second) {
      throw std::invalid_argument("colors must have different names, got '" + color.name +
                                  "' twice");
    }
  }
  if (options.minimum_area < 1) {
    throw std::invalid_argument("minimum_area must be at least 1 px, got " +
                                std::to_string(options.minimum_area));
  }
  if (options.smoothing != 1) smoothed_.emplace(colors_, options.smoothing);
  if (options.maximum_count < 1) {
    throw std::invalid_argument("maximum_count must be at least 1, got " +
                                std::to_string(options.maximum_count));
  }
}

BlobsByColor BlobFinder::find(const ImageView& image) {
  for (Components& c : components_) {
    c.runs.clear();
    c.regions.clear();
  }
  if (smoothed_) smoothed_->begin(image);
  for (int v = 0; v < image.height; ++v) {
    if (smoothed_) {
      smoothed_->next_row(bits_);
    } else {
      classifier_.classify(image.row(v), image.width, bits_);
    }
    for (std::size_t i = 0; i < colors_.size(); ++i) add_row(i, v, image.width);
  }
  BlobsByColor found;
  for (std::size_t i = 0; i < colors_.size(); ++i) found[colors_[i].name] = blobs(i, image);
  return found;
}

void BlobFinder::add_row(std::size_t color, int v, int width) {
  Components& c = components_[color];
  std::swap(c.above, c.runs);
  c.runs.clear();
  std::size_t first_above = 0;
  for_each_run(bits_[color], width, [&](int left, int right) {
    const std::int64_t length = right - left;
    // sum of u over the run = length (left + right - 1) / 2
    const std::int64_t sum_u = length * (left + right - 1) / 2;
    std::size_t region = c.regions.size();
    c.regions.push_back({region, length, sum_u, length * v, {left, v, right, v + 1}});
    while (first_above < c.above.size() && c.above[first_above].right < left) ++first_above;
    for (std::size_t i = first_above; i < c.above.size() && c.above[i].left <= right; ++i) {
      region = join(c.regions, c.above[i].region, region);
    }
    c.runs.push_back({left, right, region});
  });
}

std::vector<Blob> BlobFinder::blobs(std::size_t color, const ImageView& image) const {
  std::vector<const Region*> kept;
  const std::vector<Region>& regions = components_[color].regions;
  for (std::size_t i = 0; i < regions.size(); ++i) {
    const bool is_root = regions[i].parent == i;
    if (is_root && regions[i].area >= options_.minimum_area) kept.push_back(&regions[i]);
  }
  const auto count = std::min(kept.size(), static_cast<std::size_t>(options_.maximum_count));
  const auto larger = [](const Region* a, const Region* b) {
    return std::make_tuple(-a->area, a->box.top, a->box.left) <
           std::make_tuple(-b->area, b->box.top, b->box.left);
  };
  std::partial_sort(kept.begin(), kept.begin() + static_cast<std::ptrdiff_t>(count), kept.end(),
                    larger);
  std::vector<Blob> blobs;
  for (std::size_t i = 0; i < count; ++i) {
    const Region& r = *kept[i];
    const auto area = static_cast<double>(r.area);
    const bool at_border = r.box.left == 0 || r.box.top == 0 || r.box.right == image.width ||
                           r.box.bottom == image.height;
    blobs.push_back({colors_[color].name,
                     r.area,
                     {static_cast<double>(r.sum_u) / area, static_cast<double>(r.sum_v) / area},
                     r.box,
                     at_border});
  }
  return blobs;
}

}  // namespace robsim
