// The owners of pixels, and raw formats. Memory of raw frames ends with their last byte, so that
// AddressSanitizer finds each access beyond it.
#include <gtest/gtest.h>

#include <stdexcept>
#include <utility>
#include <vector>

#include "raw/from_rgb.hpp"
#include "robsim/base/simd/cpu_path.hpp"
#include "robsim/imaging/image.hpp"
#include "robsim/imaging/raw/pixel_format.hpp"

namespace robsim {
namespace {

// --- owners

TEST(Image, OneWithoutPixelsIsAnEmptyView) {
  Image image;
  EXPECT_TRUE(image.empty());
  EXPECT_TRUE(image.writable_view().box().empty());
}

TEST(Image, BorrowedPixelsAreNotWritten) {
  Image owner(4, 3);
  Image borrowed(owner.view(), nullptr);
  EXPECT_THROW(borrowed.writable_view(), std::logic_error);
  EXPECT_EQ(owner.writable_view().data, owner.view().data);
}

TEST(ImagePool, GivesMemoryAgainWhenNobodyHoldsItAndItHasTheSize) {
  ImagePool pool;
  Image first = pool.take(4, 3);
  const std::uint8_t* const pixels = first.view().data;
  EXPECT_NE(pool.take(4, 3).view().data, pixels) << "still held";
  first = {};
  for (const auto& [width, height] : {std::pair{5, 3}, std::pair{4, 2}}) {
    const Image other = pool.take(width, height);
    EXPECT_EQ(other.width(), width);
    EXPECT_EQ(other.height(), height);
    EXPECT_NE(other.view().data, pixels);
  }
  EXPECT_EQ(pool.take(4, 3).view().data, pixels);
}

// --- raw formats

bool has_size(const PixelFormat& format, int width, int height) {
  try {
    check_size(format, width, height);
  } catch (const std::invalid_argument&) {
    return false;
  }
  return true;
}

// Rows that end without their gap, as those of a part of a frame do.
std::vector<std::uint8_t> converted(const PixelFormat& format, int width, int height, int gap) {
  const std::size_t row = bytes_of_row(format, width);
  const std::size_t stride = row + static_cast<std::size_t>(gap);
  std::vector<std::uint8_t> raw(stride * static_cast<std::size_t>(height - 1) + row);
  for (std::size_t i = 0; i < raw.size(); ++i) raw[i] = static_cast<std::uint8_t>(31 * i * i + i);
  const std::ptrdiff_t rgb_stride = 3 * width + gap;
  std::vector<std::uint8_t> rgb(static_cast<std::size_t>(rgb_stride * (height - 1) + 3 * width));
  to_rgb({raw.data(), width, height, static_cast<std::ptrdiff_t>(stride), format},
         {rgb.data(), width, height, rgb_stride});
  return rgb;
}

TEST(RawFormats, StayWithinTheirBytesAndAreTheSameOnAllPaths) {
  const simd::CpuPath before = simd::cpu_path();
  for (const PixelFormat& format : pixel_formats()) {
    for (int width = 1; width <= 140; ++width) {
      for (const int height : {1, 2, 3}) {
        if (!has_size(format, width, height)) continue;
        std::vector<std::vector<std::uint8_t>> results;
        for (const simd::CpuPath path : simd::cpu_paths()) {
          simd::force_cpu_path(path);
          results.push_back(converted(format, width, height, width % 3));
        }
        EXPECT_EQ(results.front(), results.back()) << format.name << ", " << width;
      }
    }
  }
  simd::force_cpu_path(before);
}

TEST(RawFormats, AreWrittenWithinTheirBytes) {
  for (const PixelFormat& format : pixel_formats()) {
    for (int width = 2; width <= 40; ++width) {
      if (!has_size(format, width, 3)) continue;
      const std::vector<std::uint8_t> rgb(static_cast<std::size_t>(9 * width), 99);
      std::vector<std::uint8_t> raw(bytes_of(format, width, 3));
      from_rgb({rgb.data(), width, 3, 3 * width}, format, raw.data());
      EXPECT_NE(raw.front(), 0) << format.name;
      EXPECT_NE(raw.back(), 0) << format.name;
    }
  }
}

TEST(RawFormats, RefuseViewsThatDoNotFit) {
  std::vector<std::uint8_t> bytes(300);
  const PixelFormat& yuv422 = pixel_format_named("yuv422");
  const RawView raw{bytes.data(), 8, 4, 16, yuv422};
  EXPECT_THROW(to_rgb(raw, {bytes.data(), 8, 5, 24}), std::invalid_argument);
  EXPECT_THROW(to_rgb(raw, {bytes.data(), 8, 4, 23}), std::invalid_argument);
  EXPECT_THROW(to_rgb({bytes.data(), 8, 4, 15, yuv422}, {bytes.data(), 8, 4, 24}),
               std::invalid_argument);
  EXPECT_THROW(raw_view(bytes.data(), 63, yuv422, 8, 4), std::invalid_argument);
}

}  // namespace
}  // namespace robsim
