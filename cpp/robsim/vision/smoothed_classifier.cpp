#include "robsim/vision/smoothed_classifier.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "robsim/vision/yuv_planes.hpp"

namespace robsim {

namespace {

// Calls f(first, last) for each stretch first <= i < last of words that fulfil a condition.
template <typename Condition, typename F>
void for_each_stretch(std::size_t words, Condition&& condition, F&& f) {
  for (std::size_t first = 0; first < words;) {
    std::size_t last = first;
    while (last < words && condition(last)) ++last;
    if (last > first) f(first, last);
    first = last + 1;
  }
}

// result[i] = flags[i - 1] | flags[i] | flags[i + 1]
template <typename Flags>
void widen(const Flags& flags, std::vector<std::uint8_t>& result) {
  const std::size_t count = flags.size();
  for (std::size_t i = 0; i < count; ++i) {
    result[i] = flags[i] || (i > 0 && flags[i - 1]) || (i + 1 < count && flags[i + 1]);
  }
}

}  // namespace

SmoothedClassifier::SmoothedClassifier(const std::vector<ColorClass>& classes, int window)
    : window_(window), screen_(classes) {
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
      limits_.back().push_back({channel, static_cast<WindowSums::Sum>(lower * area),
                                static_cast<WindowSums::Sum>((upper + 1) * area - 1)});
      channels_[channel].is_needed = true;
    }
    // First what a neutral pixel, with 128 in every channel, does not fulfil.
    std::stable_partition(limits_.back().begin(), limits_.back().end(),
                          [&](const SumLimits& limit) {
                            return limit.lower > 128 * area || limit.upper < 128 * area;
                          });
  }
}

SmoothedClassifier::Flags& SmoothedClassifier::may_hold(int v) {
  return may_hold_[static_cast<std::size_t>(v % (window_ + 1))];
}

std::uint8_t* SmoothedClassifier::row(Channel& channel, int v) {
  return channel.rows.data() + 64 * words_ * static_cast<std::size_t>(v % (window_ + 1));
}

int SmoothedClassifier::within(int v) const { return std::clamp(v, 0, image_.height - 1); }

void SmoothedClassifier::begin(const ImageView& image) {
  image_ = image;
  v_ = 0;
  words_ = words_of(image.width);
  const auto window = static_cast<std::size_t>(window_);
  for (Channel& channel : channels_) {
    if (!channel.is_needed) continue;
    channel.rows.resize(64 * words_ * (window + 1));
    channel.columns.resize(64 * words_ + window);
    channel.sums.resize(64 * words_);
  }
  may_hold_.resize(window + 1);
  suspects_.assign(words_, 0);
  for (Flags* flags : {&active_, &is_summed_, &was_summed_}) flags->assign(words_, 0);
  const int reach = window_ / 2;
  for (int v = 0; v <= within(reach); ++v) look(v);
  for (int v = -reach; v <= reach; ++v) {
    for (std::size_t i = 0; i < words_; ++i) suspects_[i] += may_hold(within(v))[i];
  }
}

void SmoothedClassifier::next_row(std::vector<BitRow>& bits) {
  if (v_ > 0) look_down();
  find_active();
  const auto goes_on = [&](std::size_t i) { return is_summed_[i] && was_summed_[i]; };
  const auto begins = [&](std::size_t i) { return is_summed_[i] && !was_summed_[i]; };
  for_each_stretch(words_, goes_on, [&](auto first, auto last) { move_down(first, last); });
  for_each_stretch(words_, begins, [&](auto first, auto last) { fill(first, last); });
  for (BitRow& row : bits) row.assign(words_, 0);
  const auto is_active = [&](std::size_t i) { return active_[i] != 0; };
  for_each_stretch(words_, is_active, [&](auto first, auto last) { classify(first, last, bits); });
  ++v_;
}

void SmoothedClassifier::look(int v) {
  // In noise every pixel is colourful: a look at every eighth row finds out when that ends.
  const auto is_set = [](std::uint8_t flag) { return flag != 0; };
  if (v % 8 != 0 && std::all_of(may_hold(v - 1).begin(), may_hold(v - 1).end(), is_set)) {
    may_hold(v).assign(words_, 1);
  } else {
    screen_.look(image_.row(v), image_.width, may_hold(v));
  }
}

void SmoothedClassifier::look_down() {
  const int reach = window_ / 2;
  if (v_ + reach < image_.height) look(v_ + reach);
  const Flags& in = may_hold(within(v_ + reach));
  const Flags& out = may_hold(within(v_ - 1 - reach));
  for (std::size_t i = 0; i < words_; ++i) suspects_[i] += in[i] - out[i];
}

void SmoothedClassifier::find_active() {
  widen(suspects_, active_);
  std::swap(is_summed_, was_summed_);
  widen(active_, is_summed_);
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
  const int reach = window_ / 2;
  for (int v = within(v_ - reach); v <= within(v_ + reach); ++v) convert(v, first, last);
  const std::size_t count = 64 * (last - first);
  const std::vector<std::uint8_t> nothing(count, 0);
  const WindowSums loops = window_sums(window_);
  for (Channel& channel : channels_) {
    if (!channel.is_needed) continue;
    WindowSums::Sum* columns = channel.columns.data() + reach + 64 * first;
    std::fill_n(columns, count, WindowSums::Sum{0});
    for (int v = v_ - reach; v <= v_ + reach; ++v) {
      loops.exchange(row(channel, within(v)) + 64 * first, nothing.data(), count, columns);
    }
  }
}

void SmoothedClassifier::move_down(std::size_t first, std::size_t last) {
  const int reach = window_ / 2;
  if (v_ + reach < image_.height) convert(v_ + reach, first, last);
  const WindowSums loops = window_sums(window_);
  for (Channel& channel : channels_) {
    if (!channel.is_needed) continue;
    loops.exchange(row(channel, within(v_ + reach)) + 64 * first,
                   row(channel, within(v_ - 1 - reach)) + 64 * first, 64 * (last - first),
                   channel.columns.data() + reach + 64 * first);
  }
}

void SmoothedClassifier::classify(std::size_t first, std::size_t last, std::vector<BitRow>& bits) {
  const auto reach = static_cast<std::size_t>(window_ / 2);
  const auto width = static_cast<std::size_t>(image_.width);
  const WindowSums loops = window_sums(window_);
  for (Channel& channel : channels_) {
    if (!channel.is_needed) continue;
    WindowSums::Sum* columns = channel.columns.data();
    if (first == 0) std::fill_n(columns, reach, columns[reach]);
    if (last == words_) std::fill_n(columns + reach + width, reach, columns[reach + width - 1]);
    loops.add_up(columns + 64 * first, 64 * (last - first), channel.sums.data() + 64 * first);
  }
  for (std::size_t i = 0; i < limits_.size(); ++i) {
    for (std::size_t word = first; word < last; ++word) {
      std::uint64_t members = ~std::uint64_t{0};
      for (const SumLimits& limit : limits_[i]) {
        if (members == 0) break;
        const WindowSums::Sum* sums = channels_[limit.channel].sums.data() + 64 * word;
        members &= loops.within(sums, limit.lower, limit.upper);
      }
      bits[i][word] = members;
    }
    if (last == words_ && width % 64 != 0) bits[i].back() &= (std::uint64_t{1} << (width % 64)) - 1;
  }
}

}  // namespace robsim
