#include "robsim/vision/pixels/row_classifier.hpp"

#include <algorithm>
#include <set>
#include <stdexcept>
#include <string>

#include "robsim/base/system.hpp"
#include "robsim/vision/pixels/smoothing.hpp"

namespace robsim::pixels {

namespace {

// Column sums before and after those of a row: as many as fit in a cache line.
constexpr std::size_t margin = 32;

}  // namespace

SmoothedClassifier::SmoothedClassifier(const std::vector<ColorClass>& classes, int window)
    : window_(window), screen_(classes) {
  checked(window, window >= 3 && window <= maximum_window && window % 2 == 1,
          "smoothing must be 1 = off, or a window of 3, 5, ... 15 px");
  const int area = window * window;
  for (const ColorClass& color : classes) {
    limits_.emplace_back();
    for (std::size_t channel = 0; channel < 3; ++channel) {
      const int lower = color.lower[channel];
      const int upper = color.upper[channel];
      if (lower == 0 && upper == 255) continue;
      // lower <= floor(sum / area) <= upper
      limits_.back().push_back({channel, static_cast<WindowSums::Sum>(lower * area),
                                static_cast<WindowSums::Sum>((upper + 1) * area - 1)});
      channels_[channel].is_needed = true;
    }
    // The limits that a neutral pixel, 128 in every channel, violates come first.
    std::stable_partition(limits_.back().begin(), limits_.back().end(),
                          [&](const WindowSums::Limits& limit) {
                            return limit.lower > 128 * area || limit.upper < 128 * area;
                          });
  }
}

SmoothedClassifier::Blocks& SmoothedClassifier::may_contain(int v) {
  return may_contain_[static_cast<std::size_t>(v % (window_ + 1))];
}

std::uint8_t* SmoothedClassifier::row(Channel& channel, int v) {
  return channel.rows.data() + 64 * words_ * static_cast<std::size_t>(v % (window_ + 1));
}

WindowSums::Sum* SmoothedClassifier::column(Channel& channel, std::size_t u) {
  const auto begin = reinterpret_cast<std::uintptr_t>(channel.columns.data());
  const std::size_t unaligned = begin % 64 / sizeof(WindowSums::Sum);
  return channel.columns.data() + (2 * margin - unaligned) + u;
}

int SmoothedClassifier::clamped(int v) const { return std::clamp(v, 0, image_.height - 1); }

void SmoothedClassifier::begin(const ImageView& image) {
  image_ = image;
  v_ = 0;
  unscreened_rows_ = 0;
  grey_rows_ = 0;
  words_ = words_of(image.width);
  const auto window = static_cast<std::size_t>(window_);
  for (Channel& channel : channels_) {
    if (!channel.is_needed) continue;
    channel.rows.resize(64 * words_ * (window + 1));
    channel.columns.resize(64 * words_ + 2 * margin + WindowSums::read_ahead);
    channel.sums.resize(64 * words_);
  }
  may_contain_.resize(window + 1);
  for (Blocks* some : {&is_summed_, &was_summed_, &continued_, &begun_}) {
    some->assign(words_of(blocks()), 0);
  }
  for (int v = 0; v <= clamped(window_ / 2); ++v) screen_row(v);
}

void SmoothedClassifier::next_row(std::vector<BitRow>& bits) {
  for (BitRow& row : bits) row.resize(words_);
  const int half_width = window_ / 2;
  if (v_ > 0 && v_ + half_width < image_.height) screen_row(v_ + half_width);
  if (unscreened_rows_ > window_) {
    // All rows of this window and of the previous one may contain members everywhere.
    move_down(0, words_);
    classify(0, words_, bits);
  } else {
    for (BitRow& row : bits) std::fill(row.begin(), row.end(), 0);
    if (grey_rows_ <= window_) {
      find_active();
      classify_active(bits);
    }
  }
  ++v_;
}

void SmoothedClassifier::screen_row(int v) {
  // In noise no pixel is grey: screening every eighth row is enough to notice the end of it.
  const bool is_assumed = v % 8 != 0 && unscreened_rows_ > 0;
  if (is_assumed) {
    set_all(may_contain(v), blocks());
  } else {
    screen_.screen(image_.row(v), image_.width, may_contain(v));
  }
  const bool is_unscreened = is_assumed || is_full(may_contain(v), blocks());
  unscreened_rows_ = is_unscreened ? unscreened_rows_ + 1 : 0;
  grey_rows_ = is_empty(may_contain(v)) ? grey_rows_ + 1 : 0;
}

void SmoothedClassifier::find_active() {
  candidates_.assign(words_of(blocks()), 0);
  const int half_width = window_ / 2;
  for (int v = clamped(v_ - half_width); v <= clamped(v_ + half_width); ++v) {
    const Blocks& row = may_contain(v);
    for (std::size_t i = 0; i < row.size(); ++i) candidates_[i] |= row[i];
  }
  std::swap(is_summed_, was_summed_);
  widen(candidates_, blocks(), active_);
  widen(active_, blocks(), is_summed_);
}

void SmoothedClassifier::classify_active(std::vector<BitRow>& bits) {
  for (std::size_t i = 0; i < is_summed_.size(); ++i) {
    continued_[i] = is_summed_[i] & was_summed_[i];
    begun_[i] = is_summed_[i] & ~was_summed_[i];
  }
  for_each_run(continued_, blocks(),
               [&](std::size_t first, std::size_t last) { move_down(first, last); });
  for_each_run(begun_, blocks(), [&](std::size_t first, std::size_t last) { fill(first, last); });
  for_each_run(active_, blocks(),
               [&](std::size_t first, std::size_t last) { classify(first, last, bits); });
}

void SmoothedClassifier::convert(int v, std::size_t first, std::size_t last) {
  std::uint8_t* planes[3] = {};
  for (int channel = 0; channel < 3; ++channel) {
    if (channels_[channel].is_needed) planes[channel] = row(channels_[channel], v);
  }
  const int end = std::min(image_.width, static_cast<int>(64 * last));
  convert_to_planes(image_.row(v), static_cast<int>(64 * first), end, planes);
}

void SmoothedClassifier::fill(std::size_t first, std::size_t last) {
  const int half_width = window_ / 2;
  for (int v = clamped(v_ - half_width); v <= clamped(v_ + half_width); ++v)
    convert(v, first, last);
  const std::size_t count = 64 * (last - first);
  const std::vector<std::uint8_t> zeros(count, 0);
  const WindowSums loops = window_sums(window_);
  for (Channel& channel : channels_) {
    if (!channel.is_needed) continue;
    WindowSums::Sum* columns = column(channel, 64 * first);
    std::fill_n(columns, count, WindowSums::Sum{0});
    for (int v = v_ - half_width; v <= v_ + half_width; ++v) {
      loops.exchange(row(channel, clamped(v)) + 64 * first, zeros.data(), count, columns);
    }
  }
}

void SmoothedClassifier::move_down(std::size_t first, std::size_t last) {
  const int half_width = window_ / 2;
  if (v_ + half_width < image_.height) convert(v_ + half_width, first, last);
  const WindowSums loops = window_sums(window_);
  for (Channel& channel : channels_) {
    if (!channel.is_needed) continue;
    loops.exchange(row(channel, clamped(v_ + half_width)) + 64 * first,
                   row(channel, clamped(v_ - 1 - half_width)) + 64 * first, 64 * (last - first),
                   column(channel, 64 * first));
  }
}

void SmoothedClassifier::classify(std::size_t first, std::size_t last, std::vector<BitRow>& bits) {
  const auto half_width = static_cast<std::size_t>(window_ / 2);
  const auto width = static_cast<std::size_t>(image_.width);
  const std::size_t words = last - first;
  const WindowSums loops = window_sums(window_);
  for (Channel& channel : channels_) {
    if (!channel.is_needed) continue;
    WindowSums::Sum* columns = column(channel, 0);
    if (first == 0) std::fill_n(columns - half_width, half_width, columns[0]);
    // The windows at the end of a word before the last one may reach beyond the border, too.
    if (64 * last + half_width > width) {
      std::fill_n(columns + width, half_width, columns[width - 1]);
    }
    loops.sum(columns + 64 * first - half_width, words, channel.sums.data() + 64 * first);
  }
  for (std::size_t i = 0; i < limits_.size(); ++i) {
    std::uint64_t* const row = bits[i].data() + first;
    std::fill_n(row, words, ~std::uint64_t{0});
    for (const WindowSums::Limits& limits : limits_[i]) {
      loops.limit(channels_[limits.channel].sums.data() + 64 * first, limits, words, row);
    }
  }
  if (last == words_) clear_beyond(bits, image_.width);
}

RowClassifier::RowClassifier(const std::vector<ColorClass>& classes, int smoothing)
    : classifier_(classes), bits_(classes.size()) {
  std::set<std::string> names;
  for (const ColorClass& color : classes) {
    check_color_class(color);
    if (!names.insert(color.name).second) {
      throw std::invalid_argument("colors must have different names, got '" + color.name +
                                  "' twice");
    }
  }
  if (smoothing != 1) smoothed_.emplace(classes, smoothing);
}

void RowClassifier::begin(const ImageView& image) {
  image_ = image;
  v_ = 0;
  if (smoothed_) smoothed_->begin(image);
}

const std::vector<BitRow>& RowClassifier::next_row() {
  if (smoothed_) {
    smoothed_->next_row(bits_);
  } else {
    classifier_.classify(image_.row(v_++), image_.width, bits_);
  }
  return bits_;
}

}  // namespace robsim::pixels
