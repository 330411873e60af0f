#include "robsim/world/background.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "robsim/base/system.hpp"

namespace robsim {

namespace {

std::int64_t floor_divide(std::int64_t a, std::int64_t b) { return a / b - (a % b < 0 ? 1 : 0); }

}  // namespace

Background::Background(Layer floor, Layer home, int shadow_left, double shadow_factor)
    : floor_(std::move(floor)),
      home_(std::move(home)),
      shadow_left_(shadow_left),
      shadow_factor_(shadow_factor) {
  for (const Image* image : {&floor_.lit, &floor_.shadowed, &home_.shadowed}) {
    if (image->width() != width() || image->height() != height()) {
      throw std::invalid_argument("floor and home must be images of one size");
    }
  }
  if (!(shadow_factor >= 0 && shadow_factor <= 1)) {
    throw std::invalid_argument("shadow_factor must lie within 0..1, got " +
                                to_text(shadow_factor));
  }
}

void Background::copy(const PixelBox& box, const Pan& pan, const WritableView& view) const {
  for (int v = box.top; v < box.bottom; ++v) {
    const std::int64_t world_v = std::int64_t{v} + pan.v;
    const std::int64_t tile_v = floor_divide(world_v, height());
    const int source_v = static_cast<int>(world_v - tile_v * height());
    for (int u = box.left; u < box.right;) {
      const std::int64_t world_u = std::int64_t{u} + pan.u;
      const std::int64_t tile_u = floor_divide(world_u, width());
      const bool lit = u < shadow_left_;
      const std::int64_t tile_end = (tile_u + 1) * width() - pan.u;
      int end = static_cast<int>(std::min<std::int64_t>(box.right, tile_end));
      if (lit) end = std::min(end, shadow_left_);
      const Layer& layer = tile_u == 0 && tile_v == 0 ? home_ : floor_;
      const Image& source = lit ? layer.lit : layer.shadowed;
      const int source_u = static_cast<int>(world_u - tile_u * width());
      std::memcpy(view.row(v) + std::ptrdiff_t{3} * u,
                  source.row(source_v) + std::ptrdiff_t{3} * source_u,
                  std::size_t{3} * static_cast<std::size_t>(end - u));
      u = end;
    }
  }
}

}  // namespace robsim
