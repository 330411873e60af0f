#include "robsim/vision/pixels/classify.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "robsim/simd/cpu_path.hpp"
#include "robsim/vision/pixels/padded_row.hpp"
#include "robsim/vision/pixels/yuv_avx2.hpp"

namespace robsim {

namespace {

std::vector<ChannelLimits> limits_of(const ColorClass& color) {
  std::vector<ChannelLimits> limits;
  for (std::size_t channel = 0; channel < 3; ++channel) {
    const int lower = color.lower[channel];
    const int upper = color.upper[channel];
    if (lower == 0 && upper == 255) continue;
    limits.push_back({channel, static_cast<std::uint8_t>(lower), static_cast<std::uint8_t>(upper)});
  }
  return limits;
}

// 64 pixels, channel by channel: loops that a compiler does several pixels at a time.
struct Planes {
  std::uint8_t channel[3][64];
};

void convert_baseline(const std::uint8_t* rgb, Planes& planes) {
  for (int i = 0; i < 64; ++i) {
    const Yuv yuv = rgb_to_yuv(rgb + 3 * i);
    planes.channel[0][i] = static_cast<std::uint8_t>(yuv.y);
    planes.channel[1][i] = static_cast<std::uint8_t>(yuv.u);
    planes.channel[2][i] = static_cast<std::uint8_t>(yuv.v);
  }
}

std::uint64_t members_baseline(const Planes& planes, const std::vector<ChannelLimits>& limits) {
  std::uint8_t is_member[64];
  std::fill_n(is_member, 64, std::uint8_t{1});
  for (const ChannelLimits& limit : limits) {
    const std::uint8_t* values = planes.channel[limit.channel];
    const std::uint8_t lower = limit.lower;
    const std::uint8_t upper = limit.upper;
    for (int i = 0; i < 64; ++i) is_member[i] &= (values[i] >= lower) & (values[i] <= upper);
  }
  return packed(is_member);
}

void classify_baseline(const std::uint8_t* rgb, int width,
                       const std::vector<std::vector<ChannelLimits>>& limits,
                       const std::vector<std::uint8_t>& may_hold, std::vector<BitRow>& bits) {
  PaddedRow row(rgb, width);
  for (std::size_t word = 0; word < may_hold.size(); ++word) {
    if (!may_hold[word]) continue;
    Planes planes;
    convert_baseline(row.pixels(word), planes);
    for (std::size_t i = 0; i < limits.size(); ++i) {
      bits[i][word] = members_baseline(planes, limits[i]);
    }
  }
}

#if ROBSIM_HAS_AVX2_CODE

// What a class asks of a channel, 32 times over.
struct WideLimits {
  __m256i lower;
  __m256i upper;
  std::size_t channel;
};

constexpr std::size_t most_limits = 3 * Classifier::most_classes;

// Bit i = pixel i lies within the limits.
ROBSIM_AVX2_INLINE std::uint32_t members(const __m256i* yuv, const WideLimits* begin,
                                         const WideLimits* end) {
  __m256i outside = _mm256_setzero_si256();
  for (const WideLimits* limit = begin; limit != end; ++limit) {
    const __m256i value = yuv[limit->channel];
    outside = _mm256_or_si256(outside, _mm256_subs_epu8(value, limit->upper));
    outside = _mm256_or_si256(outside, _mm256_subs_epu8(limit->lower, value));
  }
  return static_cast<std::uint32_t>(
      _mm256_movemask_epi8(_mm256_cmpeq_epi8(outside, _mm256_setzero_si256())));
}

ROBSIM_AVX2 void classify_avx2(const std::uint8_t* rgb, int width,
                               const std::vector<std::vector<ChannelLimits>>& limits,
                               const std::vector<std::uint8_t>& may_hold,
                               std::vector<BitRow>& bits) {
  WideLimits wide[most_limits];
  std::size_t first[Classifier::most_classes + 1] = {0};
  std::uint64_t* rows[Classifier::most_classes];
  const std::size_t count = limits.size();
  bool needs_y = false;
  for (std::size_t i = 0; i < count; ++i) {
    first[i + 1] = first[i];
    rows[i] = bits[i].data();
    for (const ChannelLimits& limit : limits[i]) {
      needs_y = needs_y || limit.channel == 0;
      wide[first[i + 1]++] = {_mm256_set1_epi8(static_cast<char>(limit.lower)),
                              _mm256_set1_epi8(static_cast<char>(limit.upper)), limit.channel};
    }
  }
  PaddedRow row(rgb, width);
  for (std::size_t word = 0; word < may_hold.size(); ++word) {
    if (!may_hold[word]) continue;
    const std::uint8_t* pixels = row.pixels(word);
    __m256i low[3];
    __m256i high[3];
    convert_block(pixels, needs_y, low);
    convert_block(pixels + 96, needs_y, high);
    for (std::size_t i = 0; i < count; ++i) {
      const WideLimits* begin = wide + first[i];
      const WideLimits* end = wide + first[i + 1];
      rows[i][word] = members(low, begin, end) | (std::uint64_t{members(high, begin, end)} << 32);
    }
  }
}

#endif

}  // namespace

Classifier::Classifier(const std::vector<ColorClass>& classes) : screen_(classes) {
  if (classes.size() > most_classes) {
    throw std::invalid_argument("colors must be at most " + std::to_string(most_classes) +
                                " classes, got " + std::to_string(classes.size()));
  }
  for (const ColorClass& color : classes) limits_.push_back(limits_of(color));
}

void Classifier::classify(const std::uint8_t* rgb, int width, std::vector<BitRow>& bits) {
  for (BitRow& row : bits) row.assign(words_of(width), 0);
  screen_.look(rgb, width, may_hold_);
  ROBSIM_PICK(classify_baseline, classify_avx2)(rgb, width, limits_, may_hold_, bits);
  const int left = width % 64;
  if (left == 0) return;
  for (BitRow& row : bits) row.back() &= (std::uint64_t{1} << left) - 1;
}

}  // namespace robsim
