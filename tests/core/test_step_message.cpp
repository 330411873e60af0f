// The bytes of a step between the process of a grader and that of a submission.
#include "robsim/simulation/remote/step_message.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>

namespace robsim {
namespace {

StepMessage full_message() {
  StepMessage message;
  message.k = 7;
  message.t = 1.4;
  message.done = measure_bit | estimate_bit | control_bit;
  message.measurement = Measurement();
  message.measurement->pose = {120.5, 80.25, 0.5};
  Estimate estimate;
  estimate.pose = {120, 80, 0.4};
  estimate.covariance.setIdentity();
  message.estimate = estimate;
  message.u = Input();
  message.blobs = {{1.5, 2.5}, {3.5, 4.5}};
  message.next_slot = 2;
  return message;
}

TEST(StepMessage, ComesBackAsItWas) {
  const std::string bytes = to_bytes(full_message());
  const StepMessage back = message_from(bytes.data(), bytes.size());
  EXPECT_EQ(back.k, 7);
  EXPECT_EQ(back.t, 1.4);
  EXPECT_EQ(back.done, measure_bit | estimate_bit | control_bit);
  ASSERT_TRUE(back.measurement && back.estimate && back.u);
  EXPECT_EQ(back.measurement->pose.x, 120.5);
  EXPECT_EQ(back.estimate->covariance(2, 2), 1);
  ASSERT_EQ(back.blobs.size(), 2);
  EXPECT_EQ(back.blobs[1].y, 4.5);
  EXPECT_FALSE(back.frame || back.sample || back.parameters);
  EXPECT_EQ(to_bytes(back), bytes);
}

TEST(StepMessage, IsRefusedWhereItIsCutOrTooLong) {
  const std::string bytes = to_bytes(full_message());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const std::string cut = bytes.substr(0, size);  // of its own, so that reading beyond is seen
    EXPECT_THROW(message_from(cut.data(), cut.size()), MessageError) << size;
  }
  const std::string longer = bytes + '\0';
  EXPECT_THROW(message_from(longer.data(), longer.size()), MessageError);
}

TEST(StepMessage, OfNumbersThatCannotBeIsRefused) {
  StepMessage message = full_message();
  message.estimate->covariance(1, 1) = -1;
  std::string bytes = to_bytes(message);
  EXPECT_THROW(message_from(bytes.data(), bytes.size()), MessageError);
  message = full_message();
  message.estimate->pose.x = std::numeric_limits<double>::quiet_NaN();
  bytes = to_bytes(message);
  EXPECT_THROW(message_from(bytes.data(), bytes.size()), MessageError);
}

// What is accepted can be sent on: nothing in it leads beyond the message.
TEST(StepMessage, OfRandomBytesIsRefusedOrWhole) {
  std::mt19937 random(11);
  const std::string whole = to_bytes(full_message());
  int accepted = 0;
  for (int i = 0; i < 50000; ++i) {
    std::string bytes = whole;
    const auto changes = 1 + random() % 8;
    for (unsigned j = 0; j < changes; ++j) {
      bytes[random() % bytes.size()] = static_cast<char>(random() % 256);
    }
    if (random() % 4 == 0) bytes.resize(random() % (2 * bytes.size()));
    try {
      const StepMessage message = message_from(bytes.data(), bytes.size());
      EXPECT_EQ(to_bytes(message).size(), bytes.size());
      ++accepted;
    } catch (const MessageError&) {
    }
  }
  EXPECT_GT(accepted, 0);
  EXPECT_LT(accepted, 50000);
}

}  // namespace
}  // namespace robsim
