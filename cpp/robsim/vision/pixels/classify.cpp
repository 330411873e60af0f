#include "robsim/vision/pixels/classify.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "robsim/base/simd/cpu_path.hpp"
#include "robsim/vision/pixels/padded_row.hpp"
#include "robsim/vision/pixels/yuv_avx2.hpp"

namespace robsim::pixels {

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

// 64 pixels, channel by channel, so that the compiler can vectorise the loops over them.
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
  return pack_bits(is_member);
}

void classify_baseline(const std::uint8_t* rgb, int width,
                       const std::vector<std::vector<ChannelLimits>>& limits,
                       const BitRow& may_contain, std::vector<BitRow>& bits) {
  PaddedRow row(rgb, width);
  for (std::size_t word = 0; word < row.blocks(); ++word) {
    if (!is_set(may_contain, static_cast<int>(word))) continue;
    Planes planes;
    convert_baseline(row.block(word), planes);
    for (std::size_t i = 0; i < limits.size(); ++i) {
      bits[i][word] = members_baseline(planes, limits[i]);
    }
  }
}

#if ROBSIM_HAS_AVX2_CODE

// The limits of a class in a channel, each 32 times.
struct RegisterLimits {
  __m256i lower;
  __m256i upper;
  std::size_t channel;
};

constexpr std::size_t maximum_limits = 3 * Classifier::maximum_classes;

// Bit i is set if pixel i lies within the limits.
ROBSIM_AVX2_INLINE std::uint32_t members(const __m256i* yuv, const RegisterLimits* begin,
                                         const RegisterLimits* end) {
  __m256i outside = _mm256_setzero_si256();
  for (const RegisterLimits* limit = begin; limit != end; ++limit) {
    const __m256i value = yuv[limit->channel];
    outside = _mm256_or_si256(outside, _mm256_subs_epu8(value, limit->upper));
    outside = _mm256_or_si256(outside, _mm256_subs_epu8(limit->lower, value));
  }
  return static_cast<std::uint32_t>(
      _mm256_movemask_epi8(_mm256_cmpeq_epi8(outside, _mm256_setzero_si256())));
}

ROBSIM_AVX2 void classify_avx2(const std::uint8_t* rgb, int width,
                               const std::vector<std::vector<ChannelLimits>>& limits,
                               const BitRow& may_contain, std::vector<BitRow>& bits) {
  RegisterLimits registers[maximum_limits];
  std::size_t first[Classifier::maximum_classes + 1] = {0};
  std::uint64_t* rows[Classifier::maximum_classes];
  const std::size_t count = limits.size();
  bool needs_y = false;
  for (std::size_t i = 0; i < count; ++i) {
    first[i + 1] = first[i];
    rows[i] = bits[i].data();
    for (const ChannelLimits& limit : limits[i]) {
      needs_y = needs_y || limit.channel == 0;
      registers[first[i + 1]++] = {_mm256_set1_epi8(static_cast<char>(limit.lower)),
                                   _mm256_set1_epi8(static_cast<char>(limit.upper)), limit.channel};
    }
  }
  PaddedRow row(rgb, width);
  for (std::size_t word = 0; word < row.blocks(); ++word) {
    if (!is_set(may_contain, static_cast<int>(word))) continue;
    const std::uint8_t* pixels = row.block(word);
    __m256i low[3];
    __m256i high[3];
    convert_block(pixels, needs_y, low);
    convert_block(pixels + 96, needs_y, high);
    for (std::size_t i = 0; i < count; ++i) {
      const RegisterLimits* begin = registers + first[i];
      const RegisterLimits* end = registers + first[i + 1];
      rows[i][word] = members(low, begin, end) | (std::uint64_t{members(high, begin, end)} << 32);
    }
  }
}

#endif

}  // namespace

Classifier::Classifier(const std::vector<ColorClass>& classes) : screen_(classes) {
  if (classes.size() > maximum_classes) {
    throw std::invalid_argument("colors must be at most " + std::to_string(maximum_classes) +
                                " classes, got " + std::to_string(classes.size()));
  }
  for (const ColorClass& color : classes) limits_.push_back(limits_of(color));
}

void Classifier::classify(const std::uint8_t* rgb, int width, std::vector<BitRow>& bits) {
  for (BitRow& row : bits) row.assign(words_of(width), 0);
  screen_.screen(rgb, width, may_contain_);
  if (is_empty(may_contain_)) return;
  ROBSIM_PICK(classify_baseline, classify_avx2)(rgb, width, limits_, may_contain_, bits);
  clear_beyond(bits, width);
}

}  // namespace robsim::pixels
