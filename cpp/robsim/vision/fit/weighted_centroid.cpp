#include "robsim/vision/fit/weighted_centroid.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "robsim/vision/color/color_class.hpp"

namespace robsim {

namespace {

constexpr int margin = 2;    // px around the blob
constexpr double low = 0.2;  // share of the marker's colour that counts as none, and as all of it
constexpr double high = 0.8;
constexpr double drawing_variance = 0.02 * 0.02;  // px^2: pictures are not drawn more exactly

struct Chroma {
  double u = 0, v = 0;
};

Chroma chroma_at(const ImageView& image, int u, int v) {
  const Yuv yuv = rgb_to_yuv(image.row(v) + std::ptrdiff_t{3} * u);
  return {static_cast<double>(yuv.u), static_cast<double>(yuv.v)};
}

// The mean of 3 x 3 pixels, fewer at the border of the frame.
Chroma smoothed(const ImageView& image, int u, int v) {
  Chroma sum;
  int count = 0;
  for (int j = std::max(0, v - 1); j <= std::min(image.height - 1, v + 1); ++j) {
    for (int i = std::max(0, u - 1); i <= std::min(image.width - 1, u + 1); ++i, ++count) {
      const Chroma chroma = chroma_at(image, i, j);
      sum = {sum.u + chroma.u, sum.v + chroma.v};
    }
  }
  return {sum.u / count, sum.v / count};
}

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Chroma median_of(const std::vector<Chroma>& all) {
  std::vector<double> u, v;
  for (const Chroma& chroma : all) {
    u.push_back(chroma.u);
    v.push_back(chroma.v);
  }
  return {median_of(u), median_of(v)};
}

// Within the image. A box may lie anywhere: blobs need not be those of the image.
PixelBox grown(const PixelBox& box, int by, const ImageView& image) {
  const auto moved = [](int side, int way, int last) {
    return static_cast<int>(std::clamp<std::int64_t>(std::int64_t{side} + way, 0, last));
  };
  return {moved(box.left, -by, image.width), moved(box.top, -by, image.height),
          moved(box.right, by, image.width), moved(box.bottom, by, image.height)};
}

double length(int first, int last) { return static_cast<double>(last) - first; }

bool contains(const PixelBox& box, int u, int v) {
  return u >= box.left && u < box.right && v >= box.top && v < box.bottom;
}

}  // namespace

std::optional<WeightedCentroid> weighted_centroid(const ImageView& image, const PixelBox& blob,
                                                  const Point& middle) {
  const PixelBox box = grown(blob, margin, image);
  const PixelBox frame = grown(box, 1, image);
  std::vector<Chroma> around, within;
  for (int v = frame.top; v < frame.bottom; ++v) {
    for (int u = frame.left; u < frame.right; ++u) {
      if (!contains(box, u, v)) around.push_back(chroma_at(image, u, v));
      // the middle half of the blob's box lies in most markers
      const double x = std::fabs(2.0 * u + 1 - blob.left - blob.right);
      const double y = std::fabs(2.0 * v + 1 - blob.top - blob.bottom);
      const bool is_within =
          2 * x <= length(blob.left, blob.right) && 2 * y <= length(blob.top, blob.bottom);
      if (is_within) within.push_back(smoothed(image, u, v));
    }
  }
  if (around.empty() || within.empty()) return std::nullopt;
  const Chroma floor = median_of(around);
  const Chroma marker = median_of(within);
  const Chroma color{marker.u - floor.u, marker.v - floor.v};
  const double contrast = color.u * color.u + color.v * color.v;
  if (!(contrast > 1)) return std::nullopt;
  // The share of the marker's colour: its projection on the way from the floor's to it.
  const auto share = [&](const Chroma& seen) {
    return ((seen.u - floor.u) * color.u + (seen.v - floor.v) * color.v) / contrast;
  };
  double noise = 0;
  for (const Chroma& chroma : around) noise += share(chroma) * share(chroma);
  noise /= static_cast<double>(around.size());
  double sum = 0, sum_u = 0, sum_v = 0, moment = 0;
  for (int v = box.top; v < box.bottom; ++v) {
    for (int u = box.left; u < box.right; ++u) {
      const double weight =
          std::clamp((share(smoothed(image, u, v)) - low) / (high - low), 0.0, 1.0);
      sum += weight;
      sum_u += weight * u;
      sum_v += weight * v;
      // where the weight changes with the colour, at the edge
      if (weight > 0 && weight < 1) {
        const double x = u - middle.x;
        const double y = v - middle.y;
        moment += (x * x + y * y) / 2;
      }
    }
  }
  if (!(sum > 0)) return std::nullopt;
  // var(centroid) = sum (u - centroid)^2 var(weight) / (sum weights)^2. The mean over 3 x 3 divides
  // the variance of a weight by 9, and is 9 times as much of neighbours together.
  const double of_weight = noise / ((high - low) * (high - low));
  return WeightedCentroid{{sum_u / sum, sum_v / sum},
                          moment * of_weight / (sum * sum) + drawing_variance};
}

}  // namespace robsim
