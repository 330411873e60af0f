#include "robsim/imaging/image.hpp"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <string>

namespace robsim {

namespace {
constexpr std::size_t pooled_images = 4;
}

std::string size_text(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height) + " px";
}

PixelBox intersection(const PixelBox& a, const PixelBox& b) {
  return {std::max(a.left, b.left), std::max(a.top, b.top), std::min(a.right, b.right),
          std::min(a.bottom, b.bottom)};
}

void check_region(const PixelBox& region, const ImageView& image) {
  if (!region.empty() && region.left >= 0 && region.top >= 0 && region.right <= image.width &&
      region.bottom <= image.height) {
    return;
  }
  throw std::invalid_argument("region must be (left, top, right, bottom) within the image of " +
                              size_text(image.width, image.height) + ", got (" +
                              std::to_string(region.left) + ", " + std::to_string(region.top) +
                              ", " + std::to_string(region.right - 1) + ", " +
                              std::to_string(region.bottom - 1) + ")");
}

Image::Image(int width, int height)
    : width_(width), height_(height), stride_(std::ptrdiff_t{3} * width) {
  const std::shared_ptr<std::uint8_t[]> pixels(
      new std::uint8_t[static_cast<std::size_t>(stride_) * static_cast<std::size_t>(height)]);
  writable_ = pixels.get();
  pixels_ = {pixels, pixels.get()};
}

Image::Image(const ImageView& pixels, const std::shared_ptr<const void>& owner)
    : pixels_(owner, pixels.data),
      width_(pixels.width),
      height_(pixels.height),
      stride_(pixels.stride) {}

Image::Image(const WritableView& pixels, const std::shared_ptr<const void>& owner)
    : Image(ImageView{pixels.data, pixels.width, pixels.height, pixels.stride}, owner) {
  writable_ = pixels.data;
}

WritableView Image::writable_view() {
  if (!writable_ && !empty()) throw std::logic_error("the pixels of this image are borrowed");
  return {writable_, width_, height_, stride_};
}

void copy(const ImageView& from, const WritableView& to) {
  for (int v = 0; v < from.height; ++v) {
    std::memcpy(to.row(v), from.row(v), std::size_t{3} * static_cast<std::size_t>(from.width));
  }
}

Image copy_of(const ImageView& view) {
  Image image(view.width, view.height);
  copy(view, image.writable_view());
  return image;
}

void copy_bgr(const ImageView& from, const WritableView& to) {
  for (int v = 0; v < from.height; ++v) {
    const std::uint8_t* bgr = from.row(v);
    std::uint8_t* rgb = to.row(v);
    for (int u = 0; u < from.width; ++u, bgr += 3, rgb += 3) {
      rgb[0] = bgr[2];
      rgb[1] = bgr[1];
      rgb[2] = bgr[0];
    }
  }
}

Image copy_of_bgr(const ImageView& view) {
  Image image(view.width, view.height);
  copy_bgr(view, image.writable_view());
  return image;
}

Image ImagePool::take(int width, int height) {
  const auto usable = [&](const Image& image) {
    return !image.is_shared() && image.width() == width && image.height() == height;
  };
  const auto found = std::find_if(images_.begin(), images_.end(), usable);
  if (found != images_.end()) return *found;
  if (images_.size() == pooled_images) images_.erase(images_.begin());
  images_.emplace_back(width, height);
  return images_.back();
}

}  // namespace robsim
