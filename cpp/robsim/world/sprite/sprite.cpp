#include "robsim/world/sprite/sprite.hpp"

#include <algorithm>

namespace robsim {

Sprite premultiplied(const std::uint8_t* rgba, int width, int height) {
  Sprite sprite{width, height, {}};
  sprite.pixels.resize(std::size_t{4} * width * height);
  for (std::size_t i = 0; i < sprite.pixels.size(); i += 4) {
    const float alpha = static_cast<float>(rgba[i + 3]) / 255.0F;
    for (std::size_t c = 0; c < 3; ++c) {
      sprite.pixels[i + c] = static_cast<float>(rgba[i + c]) * alpha;
    }
    sprite.pixels[i + 3] = 1.0F - alpha;
  }
  return sprite;
}

Sprite with_rim(const Sprite& sprite) {
  Sprite result{sprite.width + 3, sprite.height + 3, {}};
  result.pixels.assign(std::size_t{4} * result.width * result.height, 0.0F);
  for (std::size_t i = 3; i < result.pixels.size(); i += 4) result.pixels[i] = 1.0F;
  for (int v = 0; v < sprite.height; ++v) {
    std::copy_n(sprite.row(v), std::ptrdiff_t{4} * sprite.width, result.row(v + 1) + 4);
  }
  return result;
}

}  // namespace robsim
