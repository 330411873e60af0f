#include "robsim/vision/smoothed_classifier.hpp"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <string>

#include "robsim/cpu/cpu_path.hpp"
#include "robsim/vision/yuv_avx2.hpp"

namespace robsim {

namespace {

// Loops that a compiler does many numbers at a time, compiled for every path.
using Sums = std::uint16_t;

ROBSIM_INLINE void exchange_body(const std::uint8_t* in, const std::uint8_t* out, std::size_t count,
                                 Sums* columns) {
  for (std::size_t i = 0; i < count; ++i) {
    columns[i] = static_cast<Sums>(columns[i] + in[i] - out[i]);
  }
}

template <int window>
ROBSIM_INLINE void add_up_body(const Sums* columns, std::size_t count, Sums* sums) {
  for (std::size_t i = 0; i < count; ++i) {
    Sums sum = 0;
    for (int j = 0; j < window; ++j) sum = static_cast<Sums>(sum + columns[i + std::size_t(j)]);
    sums[i] = sum;
  }
}

struct Loops {
  void (*exchange)(const std::uint8_t*, const std::uint8_t*, std::size_t, Sums*);
  void (*add_up)(const Sums*, std::size_t, Sums*);
  std::uint64_t (*within)(const Sums*, Sums, Sums);
};

void exchange_plain(const std::uint8_t* in, const std::uint8_t* out, std::size_t count,
                    Sums* columns) {
  exchange_body(in, out, count, columns);
}

template <int window>
void add_up_plain(const Sums* columns, std::size_t count, Sums* sums) {
  add_up_body<window>(columns, count, sums);
}

// Bit i = lower <= sum i <= upper, for 64 sums
std::uint64_t within_plain(const Sums* sums, Sums lower, Sums upper) {
  std::uint8_t is_within[64];
  for (int i = 0; i < 64; ++i) {
    is_within[i] = static_cast<std::uint8_t>((sums[i] >= lower) & (sums[i] <= upper));
  }
  return packed(is_within);
}

#if ROBSIM_HAS_AVX2_CODE
ROBSIM_AVX2 void exchange_avx2(const std::uint8_t* in, const std::uint8_t* out, std::size_t count,
                               Sums* columns) {
  exchange_body(in, out, count, columns);
}

template <int window>
ROBSIM_AVX2 void add_up_avx2(const Sums* columns, std::size_t count, Sums* sums) {
  add_up_body<window>(columns, count, sums);
}

// 16 numbers of all bits or none
ROBSIM_AVX2_INLINE __m256i is_within(const Sums* sums, __m256i lower, __m256i range) {
  const __m256i above =
      _mm256_sub_epi16(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(sums)), lower);
  return _mm256_cmpeq_epi16(_mm256_min_epu16(above, range), above);
}

ROBSIM_AVX2 std::uint64_t within_avx2(const Sums* sums, Sums lower, Sums upper) {
  const __m256i least = _mm256_set1_epi16(static_cast<short>(lower));
  const __m256i range = _mm256_set1_epi16(static_cast<short>(upper - lower));
  std::uint64_t word = 0;
  for (int i = 0; i < 64; i += 32) {
    const __m256i bytes = _mm256_packs_epi16(is_within(sums + i, least, range),
                                             is_within(sums + i + 16, least, range));
    const __m256i in_order = _mm256_permute4x64_epi64(bytes, 0b11011000);  // packing joins lanes
    word |= std::uint64_t{static_cast<std::uint32_t>(_mm256_movemask_epi8(in_order))} << i;
  }
  return word;
}

ROBSIM_AVX2 void convert_avx2(const std::uint8_t* rgb, int width, std::uint8_t* const* planes) {
  for (int u = 0; u + 32 <= width; u += 32) {
    __m256i yuv[3];
    convert_block(rgb + std::ptrdiff_t{3} * u, planes[0] != nullptr, yuv);
    for (int channel = 0; channel < 3; ++channel) {
      if (!planes[channel]) continue;
      _mm256_storeu_si256(reinterpret_cast<__m256i*>(planes[channel] + u), yuv[channel]);
    }
  }
}
#endif

template <int window>
Loops loops_of() {
#if ROBSIM_HAS_AVX2_CODE
  if (cpu_path() == CpuPath::avx2) return {exchange_avx2, add_up_avx2<window>, within_avx2};
#endif
  return {exchange_plain, add_up_plain<window>, within_plain};
}

Loops loops_of(int window) {
  switch (window) {
    case 3:
      return loops_of<3>();
    case 5:
      return loops_of<5>();
    case 7:
      return loops_of<7>();
    case 9:
      return loops_of<9>();
    case 11:
      return loops_of<11>();
    case 13:
      return loops_of<13>();
    default:
      return loops_of<15>();
  }
}

void convert_plain(const std::uint8_t* rgb, int first, int width, std::uint8_t* const* planes) {
  for (int u = first; u < width; ++u) {
    const Yuv yuv = rgb_to_yuv(rgb + std::ptrdiff_t{3} * u);
    const int values[] = {yuv.y, yuv.u, yuv.v};
    for (int channel = 0; channel < 3; ++channel) {
      if (planes[channel]) planes[channel][u] = static_cast<std::uint8_t>(values[channel]);
    }
  }
}

}  // namespace

SmoothedClassifier::SmoothedClassifier(const std::vector<ColorClass>& classes, int window)
    : window_(window) {
  if (window < 3 || window > largest_window || window % 2 == 0) {
    throw std::invalid_argument("smoothing must be 1 = off, or a window of 3, 5, ... 15 px, got " +
                                std::to_string(window));
  }
  const int area = window * window;
  for (const ColorClass& color : classes) {
    limits_.emplace_back();
    for (std::size_t channel = 0; channel < 3; ++channel) {
      const int lower = color.lower[channel];
      const int upper = color.upper[channel];
      if (lower == 0 && upper == 255) continue;
      // lower <= floor(sum / area) <= upper
      limits_.back().push_back({channel, static_cast<std::uint16_t>(lower * area),
                                static_cast<std::uint16_t>((upper + 1) * area - 1)});
      channels_[channel].is_needed = true;
    }
  }
}

std::uint8_t* SmoothedClassifier::row(Channel& channel, int v) {
  return channel.rows.data() + padded_width_ * static_cast<std::size_t>(v % (window_ + 1));
}

int SmoothedClassifier::within(int v) const { return std::clamp(v, 0, image_.height - 1); }

void SmoothedClassifier::begin(const ImageView& image) {
  image_ = image;
  v_ = 0;
  padded_width_ = 64 * words_of(image.width);
  const auto window = static_cast<std::size_t>(window_);
  for (Channel& channel : channels_) {
    if (!channel.is_needed) continue;
    channel.rows.resize(padded_width_ * (window + 1));
    channel.columns.assign(padded_width_ + window, 0);
    channel.sums.resize(padded_width_);
  }
  const int reach = window_ / 2;
  for (int v = 0; v <= within(reach); ++v) convert(v);
  const std::vector<std::uint8_t> nothing(padded_width_, 0);
  const Loops loops = loops_of(window_);
  for (Channel& channel : channels_) {
    if (!channel.is_needed) continue;
    for (int v = -reach; v <= reach; ++v) {
      loops.exchange(row(channel, within(v)), nothing.data(), padded_width_,
                     channel.columns.data() + reach);
    }
  }
}

void SmoothedClassifier::convert(int v) {
  std::uint8_t* planes[3] = {};
  for (int channel = 0; channel < 3; ++channel) {
    if (channels_[channel].is_needed) planes[channel] = row(channels_[channel], v);
  }
  int done = 0;
#if ROBSIM_HAS_AVX2_CODE
  if (cpu_path() == CpuPath::avx2) {
    convert_avx2(image_.row(v), image_.width, planes);
    done = image_.width / 32 * 32;
  }
#endif
  convert_plain(image_.row(v), done, image_.width, planes);
}

void SmoothedClassifier::move_down() {
  const int reach = window_ / 2;
  const int in = within(v_ + reach);
  const int out = within(v_ - 1 - reach);
  if (in == v_ + reach) convert(in);
  const Loops loops = loops_of(window_);
  for (Channel& channel : channels_) {
    if (!channel.is_needed) continue;
    loops.exchange(row(channel, in), row(channel, out), padded_width_,
                   channel.columns.data() + reach);
  }
}

void SmoothedClassifier::next_row(std::vector<BitRow>& bits) {
  if (v_ > 0) move_down();
  ++v_;
  const auto reach = static_cast<std::size_t>(window_ / 2);
  const auto width = static_cast<std::size_t>(image_.width);
  const Loops loops = loops_of(window_);
  for (Channel& channel : channels_) {
    if (!channel.is_needed) continue;
    std::uint16_t* columns = channel.columns.data();
    std::fill_n(columns, reach, columns[reach]);
    std::fill_n(columns + reach + width, reach, columns[reach + width - 1]);
    loops.add_up(columns, width, channel.sums.data());
  }
  for (std::size_t i = 0; i < limits_.size(); ++i) {
    bits[i].resize(words_of(image_.width));
    for (std::size_t word = 0; word < bits[i].size(); ++word) {
      bits[i][word] = ~std::uint64_t{0};
      for (const SumLimits& limit : limits_[i]) {
        const std::uint16_t* sums = channels_[limit.channel].sums.data() + 64 * word;
        bits[i][word] &= loops.within(sums, limit.lower, limit.upper);
      }
    }
    if (width % 64 != 0) bits[i].back() &= (std::uint64_t{1} << (width % 64)) - 1;
  }
}

}  // namespace robsim
