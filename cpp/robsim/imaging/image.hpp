#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace robsim {

/// A rectangle of pixels: columns left <= u < right, rows top <= v < bottom.
struct PixelBox {
  int left = 0;
  int top = 0;
  int right = 0;
  int bottom = 0;

  bool empty() const { return left >= right || top >= bottom; }
};

/// A non-owning, read-only view of RGB8 pixels: 3 bytes per pixel, `stride` bytes from row to row.
struct ImageView {
  const std::uint8_t* data = nullptr;
  int width = 0;
  int height = 0;
  std::ptrdiff_t stride = 0;

  const std::uint8_t* row(int v) const { return data + v * stride; }
};

/// A non-owning, writable view of RGB8 pixels.
struct WritableView {
  std::uint8_t* data = nullptr;
  int width = 0;
  int height = 0;
  std::ptrdiff_t stride = 0;

  std::uint8_t* row(int v) const { return data + v * stride; }
  PixelBox box() const { return {0, 0, width, height}; }
};

/// A size in a message: "640 x 480 px".
std::string size_text(int width, int height);

PixelBox intersection(const PixelBox& a, const PixelBox& b);

/// Throws std::invalid_argument unless the region is not empty and lies within the image.
void check_region(const PixelBox& region, const ImageView& image);

/// An RGB8 image. Copies share its pixels, and the last one frees them.
class Image {
 public:
  Image() = default;
  Image(int width, int height);

  /// Borrows the pixels of somebody else, which `owner` keeps alive. The image shows what they are
  /// at the time, and never writes to them.
  Image(const ImageView& pixels, const std::shared_ptr<const void>& owner);

  /// The same, but writes to them, too.
  Image(const WritableView& pixels, const std::shared_ptr<const void>& owner);

  int width() const { return width_; }
  int height() const { return height_; }
  bool empty() const { return !pixels_; }
  PixelBox box() const { return {0, 0, width_, height_}; }
  const std::uint8_t* row(int v) const { return pixels_.get() + v * stride_; }
  ImageView view() const { return {pixels_.get(), width_, height_, stride_}; }

  /// Throws std::logic_error if the pixels are borrowed.
  WritableView writable_view();

  /// True while another Image (such as a frame that a user kept) holds the same pixels.
  bool is_shared() const {
    if (pixels_.use_count() > 1) return true;
    // What the last other holder read, in any thread, comes before what is written now: giving a
    // reference back is ordered after its giving one back, which looking at the count is not.
    const auto reference = pixels_;
    return false;
  }

 private:
  std::shared_ptr<const std::uint8_t> pixels_;
  std::uint8_t* writable_ = nullptr;  // the same ones; null if they are borrowed
  int width_ = 0;
  int height_ = 0;
  std::ptrdiff_t stride_ = 0;
};

/// Copies pixels to where there is room for them.
void copy(const ImageView& from, const WritableView& to);

/// The same from OpenCV's order: blue, green, red.
void copy_bgr(const ImageView& from, const WritableView& to);

Image copy_of(const ImageView& view);

/// A copy of pixels in OpenCV's order: blue, green, red.
Image copy_of_bgr(const ImageView& view);

/// Provides images of one size, reusing buffers that are no longer held elsewhere.
class ImagePool {
 public:
  Image take(int width, int height);

 private:
  std::vector<Image> images_;
};

}  // namespace robsim
