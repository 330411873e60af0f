#include "robsim/lab/capture/pixel_stream.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>
#include <vector>

namespace robsim {
namespace {

// The end that the other process writes to, and the stream at this one.
class PixelStreamTest : public testing::Test {
 protected:
  PixelStreamTest() : ends_(connected()), stream_(ends_.second, "the camera") {
    ::close(ends_.second);
  }
  ~PixelStreamTest() override { end(); }

  void end() {
    if (ends_.first >= 0) ::close(ends_.first);
    ends_.first = -1;
  }

  void write(const void* bytes, std::size_t size) {
    ASSERT_EQ(::write(ends_.first, bytes, size), static_cast<ssize_t>(size));
  }

  void send(PixelStream::Kind kind, std::uint32_t width, std::uint32_t height,
            const std::string& body, double arrived = 0) {
    const PixelStream::Head head{kind, width, height, static_cast<std::uint32_t>(body.size()),
                                 arrived};
    write(&head, sizeof head);
    write(body.data(), body.size());
  }

  std::optional<Captured> next() { return stream_.next(pool_); }

  CaptureFault fault() {
    try {
      next();
    } catch (const CaptureError& error) {
      text_ = error.what();
      return error.fault();
    }
    ADD_FAILURE() << "nothing was thrown";
    return CaptureFault::failed;
  }

  std::string text_;

 private:
  static std::pair<int, int> connected() {
    int ends[2] = {-1, -1};
    EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
    return {ends[0], ends[1]};
  }

  std::pair<int, int> ends_;
  PixelStream stream_;
  ImagePool pool_;
};

std::vector<int> pixels_of(const Captured& captured) {
  const std::uint8_t* row = captured.image.row(0);
  return {row, row + 3 * captured.image.width()};
}

TEST_F(PixelStreamTest, FramesComeWithTheirTimesInEitherOrderOfColours) {
  send(PixelStream::opened, 0, 0, "");
  send(PixelStream::rgb, 2, 1, "abcdef", 1.5);
  send(PixelStream::bgr, 2, 1, "abcdef", 2.5);
  EXPECT_FALSE(next());
  const auto rgb = next();
  ASSERT_TRUE(rgb);
  EXPECT_EQ(pixels_of(*rgb), (std::vector<int>{'a', 'b', 'c', 'd', 'e', 'f'}));
  EXPECT_EQ(rgb->arrived, 1.5);
  const auto bgr = next();
  ASSERT_TRUE(bgr);
  EXPECT_EQ(pixels_of(*bgr), (std::vector<int>{'c', 'b', 'a', 'f', 'e', 'd'}));
  EXPECT_EQ(bgr->arrived, 2.5);
}

TEST_F(PixelStreamTest, AFrameMayComeInPieces) {
  const PixelStream::Head head{PixelStream::rgb, 1, 1, 3, 0};
  const auto* const bytes = reinterpret_cast<const char*>(&head);
  write(bytes, 5);
  EXPECT_FALSE(next());
  write(bytes + 5, sizeof head - 5);
  write("ab", 2);
  EXPECT_FALSE(next());
  write("c", 1);
  const auto frame = next();
  ASSERT_TRUE(frame);
  EXPECT_EQ(pixels_of(*frame), (std::vector<int>{'a', 'b', 'c'}));
}

TEST_F(PixelStreamTest, ATornFrameHasNoPixels) {
  send(PixelStream::torn, 0, 0, "");
  const auto frame = next();
  ASSERT_TRUE(frame);
  EXPECT_FALSE(frame->is_complete);
}

TEST_F(PixelStreamTest, AFaultIsToldByItsName) {
  send(PixelStream::fault, 0, 0, "time_out\nnothing has come");
  EXPECT_EQ(fault(), CaptureFault::time_out);
  EXPECT_EQ(text_, "nothing has come");
  send(PixelStream::rgb, 1, 1, "abc");  // which may be tried again
  EXPECT_TRUE(next());
}

TEST_F(PixelStreamTest, TheEndOfTheOtherProcessIsThatOfTheCamera) {
  write("ab", 2);
  end();
  EXPECT_EQ(fault(), CaptureFault::unplugged);
}

TEST_F(PixelStreamTest, WhatDoesNotFitIsRefused) {
  send(PixelStream::rgb, 2, 2, "abc");
  EXPECT_EQ(fault(), CaptureFault::failed);
  const PixelStream::Head head{PixelStream::rgb, 1, 1, 0xffffffff, 0};
  write(&head, sizeof head);
  EXPECT_EQ(fault(), CaptureFault::failed);
  EXPECT_NE(text_.find("too large"), std::string::npos);
}

}  // namespace
}  // namespace robsim
