#include "robsim/imaging/reduce.hpp"

#include <algorithm>
#include <cstring>
#include <vector>

namespace robsim {

namespace {

constexpr int largest_factor = 4;

// One row of means of blocks. Whole rows are added before single pixels are picked from them: that
// makes sums that nobody needs, but in vectors of the processor.
template <int factor>
void reduce_row(const ImageView& from, int top, std::uint16_t* __restrict sums,
                std::uint8_t* __restrict means, std::uint8_t* __restrict to, int width) {
  constexpr std::uint16_t area = factor * factor;
  const int bytes = 3 * factor * width;
  const std::uint8_t* first = from.row(top);
  for (int i = 0; i < bytes; ++i) sums[i] = first[i];
  for (int v = 1; v < factor; ++v) {
    const std::uint8_t* next = from.row(top + v);
    for (int i = 0; i < bytes; ++i) sums[i] = static_cast<std::uint16_t>(sums[i] + next[i]);
  }
  for (int i = 0; i < bytes - 3 * (factor - 1); ++i) {
    std::uint16_t total = static_cast<std::uint16_t>(sums[i] + area / 2);
    for (int u = 1; u < factor; ++u) total = static_cast<std::uint16_t>(total + sums[i + 3 * u]);
    means[i] = static_cast<std::uint8_t>(total / area);
  }
  for (int u = 0; u < width - 1; ++u) std::memcpy(to + 3 * u, means + 3 * factor * u, 4);
  std::memcpy(to + 3 * (width - 1), means + 3 * factor * (width - 1), 3);
}

template <int factor>
Image reduced_by(const ImageView& from) {
  Image result(from.width / factor, from.height / factor);
  const WritableView to = result.writable_view();
  std::vector<std::uint16_t> sums(3 * static_cast<std::size_t>(from.width));
  std::vector<std::uint8_t> means(sums.size());
  for (int v = 0; v < to.height; ++v) {
    reduce_row<factor>(from, factor * v, sums.data(), means.data(), to.row(v), to.width);
  }
  return result;
}

Image reduced_by(const ImageView& from, int factor) {
  if (factor == 2) return reduced_by<2>(from);
  if (factor == 3) return reduced_by<3>(from);
  return reduced_by<largest_factor>(from);
}

}  // namespace

Image reduced(const Image& image, int width) {
  Image result = image;
  while (result.width() >= 2 * width && result.height() >= largest_factor) {
    const int factor = std::min(result.width() / width, largest_factor);
    result = reduced_by(result.view(), factor);
  }
  return result;
}

}  // namespace robsim
