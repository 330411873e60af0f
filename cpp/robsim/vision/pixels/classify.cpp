#include "robsim/vision/pixels/classify.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>

#include "robsim/base/simd/cpu_path.hpp"
#include "robsim/vision/pixels/bit_row.hpp"
#include "robsim/vision/pixels/yuv_avx.hpp"

namespace robsim::pixels {

namespace {

// With |R - G| <= d and |G - B| <= d:
//   U - 128 = floor((64 (B - G) + 22 (G - R))/128) lies within floor(-86 d/128)..floor(86 d/128)
//   V - 128 = floor((64 (R - G) + 10 (G - B))/128) lies within floor(-74 d/128)..floor(74 d/128)
bool excludes(const ColorClass& color, int d) {
  const int half_width[] = {86 * d, 74 * d};
  for (std::size_t i = 0; i < 2; ++i) {
    if (color.lower[i + 1] > 128 + (half_width[i] >> 7)) return true;
    if (color.upper[i + 1] < 128 + (-half_width[i] >> 7)) return true;
  }
  return false;
}

int safe_difference(const ColorClass& color) {
  int d = -1;
  while (d < 255 && excludes(color, d + 1)) ++d;
  return d;
}

// 255 for a byte whose successor is of the same pixel. The difference between the blue of a pixel
// and the red of the next one is masked out.
constexpr auto is_red_or_green = [] {
  std::array<std::uint8_t, 192> result{};
  for (std::size_t i = 0; i < result.size(); ++i) result[i] = i % 3 == 2 ? 0 : 255;
  return result;
}();

// True if |R - G| or |G - B| of any of 64 pixels exceeds the limit. Reads one byte beyond them.
// The loops run over all neighbours in memory, so that the compiler can vectorise them.
bool is_colorful(const std::uint8_t* bytes, int limit) {
  std::uint8_t differences[192];
  for (int i = 0; i < 192; ++i) {
    const std::uint8_t a = bytes[i];
    const std::uint8_t b = bytes[i + 1];
    differences[i] = static_cast<std::uint8_t>((a > b ? a : b) - (a > b ? b : a));
  }
  std::uint8_t maximum = 0;
  for (int i = 0; i < 192; ++i) {
    const std::uint8_t counted = differences[i] & is_red_or_green[i];
    maximum = maximum > counted ? maximum : counted;
  }
  return maximum > limit;
}

void screen_baseline(PaddedRow& row, int limit, BitRow& may_contain) {
  BitWriter bits(may_contain);
  for (std::size_t block = 0; block < row.blocks(); ++block) {
    bits.add(is_colorful(row.block(block), limit));
  }
  bits.finish();
}

#if ROBSIM_HAS_AVX2_CODE

// |byte i - byte i+1|, 32 times
ROBSIM_AVX2_INLINE __m256i differences(const std::uint8_t* bytes) {
  const __m256i a = simd::load(bytes);
  const __m256i b = simd::load(bytes + 1);
  return _mm256_or_si256(_mm256_subs_epu8(a, b), _mm256_subs_epu8(b, a));
}

ROBSIM_AVX2 void screen_avx2(PaddedRow& row, int limit, BitRow& may_contain) {
  BitWriter bits(may_contain);
  const __m256i limits = _mm256_set1_epi8(static_cast<char>(limit));
  for (std::size_t block = 0; block < row.blocks(); ++block) {
    const std::uint8_t* pixels = row.block(block);
    prefetch(pixels);
    __m256i maximum = _mm256_setzero_si256();
    for (int i = 0; i < 3; ++i) {
      const __m256i larger =
          _mm256_max_epu8(differences(pixels + 32 * i), differences(pixels + 32 * i + 96));
      maximum =
          _mm256_max_epu8(maximum, _mm256_and_si256(larger, simd::load(&is_red_or_green[32 * i])));
    }
    const __m256i beyond = _mm256_subs_epu8(maximum, limits);
    bits.add(!_mm256_testz_si256(beyond, beyond));
  }
  bits.finish();
}

#endif

#if ROBSIM_HAS_AVX512_CODE

// 1, 2, ... 64: where the successors of 64 bytes lie in their register and the next one
constexpr auto successors = [] {
  std::array<std::uint8_t, 64> result{};
  for (std::size_t i = 0; i < result.size(); ++i) result[i] = static_cast<std::uint8_t>(i + 1);
  return result;
}();

// |byte i - byte i+1|, 64 times. Shifting in registers costs less than loads of any alignment.
ROBSIM_AVX512_INLINE __m512i differences(__m512i bytes, __m512i next) {
  const __m512i b = _mm512_permutex2var_epi8(bytes, simd::load_wide(successors.data()), next);
  return _mm512_or_si512(_mm512_subs_epu8(bytes, b), _mm512_subs_epu8(b, bytes));
}

ROBSIM_AVX512 void screen_avx512(PaddedRow& row, int limit, BitRow& may_contain) {
  BitWriter bits(may_contain);
  const __m512i limits = _mm512_set1_epi8(static_cast<char>(limit));
  for (std::size_t block = 0; block < row.blocks(); ++block) {
    const std::uint8_t* pixels = row.block(block);
    prefetch(pixels);
    __m512i maximum = _mm512_setzero_si512();
    __m512i bytes = simd::load_wide(pixels);
    for (int i = 0; i < 3; ++i) {
      // The last byte of all is a blue one, whose successor does not count.
      const __m512i next = i < 2 ? simd::load_wide(pixels + 64 * (i + 1)) : bytes;
      maximum = _mm512_max_epu8(
          maximum,
          _mm512_and_si512(differences(bytes, next), simd::load_wide(&is_red_or_green[64 * i])));
      bytes = next;
    }
    bits.add(_mm512_cmpgt_epu8_mask(maximum, limits) != 0);
  }
  bits.finish();
}

#endif

}  // namespace

ChromaScreen::ChromaScreen(const std::vector<ColorClass>& classes) : safe_difference_(255) {
  for (const ColorClass& color : classes) {
    safe_difference_ = std::min(safe_difference_, safe_difference(color));
  }
}

void ChromaScreen::screen(const std::uint8_t* rgb, int width, BitRow& may_contain) const {
  PaddedRow row(rgb, width);
  const auto blocks = static_cast<int>(row.blocks());
  if (safe_difference_ < 0) {
    set_all(may_contain, blocks);
    return;
  }
  may_contain.resize(words_of(blocks));
  ROBSIM_PICK(screen_baseline, screen_avx2, screen_avx512)(row, safe_difference_, may_contain);
}

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
