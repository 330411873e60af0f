// Whose the pixels of an image are.
#include "robsim/imaging/image.hpp"

#include <gtest/gtest.h>

#include <stdexcept>
#include <utility>

namespace robsim {
namespace {

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

}  // namespace
}  // namespace robsim
