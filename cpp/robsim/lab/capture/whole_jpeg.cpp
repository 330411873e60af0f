#include "robsim/lab/capture/whole_jpeg.hpp"

#include <algorithm>
#include <array>
#include <vector>

namespace robsim {

namespace {

// Symbol and length of the code that 16 bits begin with; length 0: none does.
struct Code {
  std::uint8_t length = 0;
  std::uint8_t symbol = 0;
};
using Codes = std::vector<Code>;

struct Component {
  int id = 0;
  int across = 1, down = 1;  // blocks in an MCU
  int dc = 0, ac = 0;        // tables
};

constexpr std::uint8_t start_of_image = 0xd8, end_of_image = 0xd9, start_of_scan = 0xda;
constexpr std::uint8_t huffman_tables = 0xc4, restart_interval = 0xdd, first_restart = 0xd0;
constexpr std::uint8_t baseline = 0xc0, extended = 0xc1;

bool is_frame(std::uint8_t marker) {
  return marker >= 0xc0 && marker <= 0xcf && marker != huffman_tables && marker != 0xc8 &&
         marker != 0xcc;
}

// Bits of entropy-coded data, in which ff 00 is the byte ff, and any other ff ends them.
class Bits {
 public:
  Bits(const std::uint8_t* at, const std::uint8_t* end) : at_(at), end_(end) {}

  // The next 16 bits; ones after the end.
  unsigned peek() {
    while (n_ < 16) {
      unsigned byte = 0xff;
      if (at_ == end_ || (*at_ == 0xff && (end_ - at_ < 2 || at_[1] != 0))) {
        n_beyond_ += 8;
      } else {
        byte = *at_;
        at_ += byte == 0xff ? 2 : 1;
      }
      bits_ = (bits_ << 8) | byte;
      n_ += 8;
    }
    return static_cast<unsigned>(bits_ >> (n_ - 16)) & 0xffff;
  }

  void skip(int count) { n_ -= count; }

  // True if all bits were used, but for those that fill up the last byte.
  bool is_used_up() {
    const int left = n_ - n_beyond_;
    return left >= 0 && left < 8 && (at_ == end_ || *at_ == 0xff);
  }

  bool is_overrun() const { return n_ < n_beyond_; }
  const std::uint8_t* at() const { return at_; }

 private:
  const std::uint8_t* at_;
  const std::uint8_t* end_;
  std::uint64_t bits_ = 0;
  int n_ = 0;         // bits that are there
  int n_beyond_ = 0;  // of them, those after the end
};

class Walk {
 public:
  Walk(const std::uint8_t* data, std::size_t size) : at_(data), end_(data + size) {}

  bool is_whole() {
    if (!next_marker() || marker_ != start_of_image) return false;
    while (next_marker()) {
      if (marker_ == end_of_image) return has_scan_;
      const std::uint8_t* const body = at_ + 2;
      if (end_ - at_ < 2) return false;
      const int length = at_[0] << 8 | at_[1];
      if (length < 2 || end_ - at_ < length) return false;
      at_ += length;
      if (!read(body, at_)) return false;
    }
    return false;
  }

 private:
  bool next_marker() {
    if (end_ - at_ < 2 || *at_ != 0xff) return false;
    while (at_ != end_ && *at_ == 0xff) ++at_;
    if (at_ == end_) return false;
    marker_ = *at_++;
    return true;
  }

  bool read(const std::uint8_t* at, const std::uint8_t* end) {
    if (marker_ == huffman_tables) return read_tables(at, end);
    if (marker_ == restart_interval) {
      if (end - at < 2) return false;
      interval_ = at[0] << 8 | at[1];
      return true;
    }
    if (is_frame(marker_)) return read_frame(at, end);
    if (marker_ != start_of_scan) return true;
    has_scan_ = true;
    return is_huffman_ ? walk_scan(at, end) : skip_scan();
  }

  bool read_tables(const std::uint8_t* at, const std::uint8_t* end) {
    while (at != end) {
      if (end - at < 17) return false;
      const unsigned place = (*at >> 4 & 1) * 4 + (*at & 3);
      const std::uint8_t* const counts = at + 1;
      at += 17;
      Codes& codes = tables_[place];
      codes.assign(1 << 16, {});
      std::size_t first = 0;
      for (int length = 1; length <= 16; ++length) {
        const std::size_t width = std::size_t{1} << (16 - length);
        for (int i = 0; i < counts[length - 1]; ++i, first += width) {
          if (at == end || first + width > codes.size()) return false;
          std::fill_n(codes.begin() + static_cast<std::ptrdiff_t>(first), width,
                      Code{static_cast<std::uint8_t>(length), *at++});
        }
      }
    }
    return true;
  }

  bool read_frame(const std::uint8_t* at, const std::uint8_t* end) {
    is_huffman_ = marker_ == baseline || marker_ == extended;
    if (end - at < 6 || end - at < 6 + 3 * at[5]) return false;
    height_ = at[1] << 8 | at[2];
    width_ = at[3] << 8 | at[4];
    components_.clear();
    for (int i = 0; i < at[5]; ++i) {
      const std::uint8_t* const one = at + 6 + 3 * i;
      Component component;
      component.id = one[0];
      component.across = one[1] >> 4;
      component.down = one[1] & 15;
      if (component.across < 1 || component.across > 4) return false;
      if (component.down < 1 || component.down > 4) return false;
      components_.push_back(component);
    }
    return width_ > 0 && height_ > 0 && !components_.empty();
  }

  // The components of a scan, with their tables.
  bool read_scan(const std::uint8_t* at, const std::uint8_t* end, std::vector<Component>& scan) {
    if (end - at < 1 || end - at < 1 + 2 * at[0]) return false;
    for (int i = 0; i < at[0]; ++i) {
      const std::uint8_t* const one = at + 1 + 2 * i;
      const auto found = std::find_if(components_.begin(), components_.end(),
                                      [&](const Component& c) { return c.id == one[0]; });
      if (found == components_.end()) return false;
      scan.push_back(*found);
      scan.back().dc = one[1] >> 4 & 3;
      scan.back().ac = 4 + (one[1] & 3);
      if (tables_[scan.back().dc].empty() || tables_[scan.back().ac].empty()) return false;
    }
    return !scan.empty();
  }

  static int divided(int size, int by) { return (size + by - 1) / by; }

  // The number of MCUs; of a scan of one component each is a block (A.2.2).
  std::int64_t count_of(std::vector<Component>& scan) const {
    int across = 1, down = 1;
    for (const Component& c : components_) {
      across = std::max(across, c.across);
      down = std::max(down, c.down);
    }
    if (scan.size() > 1) {
      return std::int64_t{divided(width_, 8 * across)} * divided(height_, 8 * down);
    }
    Component& only = scan.front();
    const int wide = divided(divided(width_ * only.across, across), 8);
    const int high = divided(divided(height_ * only.down, down), 8);
    only.across = only.down = 1;
    return std::int64_t{wide} * high;
  }

  bool walk_scan(const std::uint8_t* at, const std::uint8_t* end) {
    std::vector<Component> scan;
    if (!read_scan(at, end, scan)) return false;
    const std::int64_t count = count_of(scan);
    Bits bits(at_, end_);
    for (std::int64_t i = 0; i < count; ++i) {
      if (interval_ && i && i % interval_ == 0) {
        if (!bits.is_used_up()) return false;
        at_ = bits.at();
        if (!next_marker() || marker_ != first_restart + (i / interval_ - 1) % 8) return false;
        bits = Bits(at_, end_);
      }
      if (!walk_unit(scan, bits)) return false;
    }
    at_ = bits.at();
    return bits.is_used_up();
  }

  bool walk_unit(const std::vector<Component>& scan, Bits& bits) const {
    for (const Component& c : scan) {
      for (int block = 0; block < c.across * c.down; ++block) {
        if (!walk_block(tables_[c.dc], tables_[c.ac], bits)) return false;
      }
    }
    return !bits.is_overrun();
  }

  static bool walk_block(const Codes& dc, const Codes& ac, Bits& bits) {
    const Code first = dc[bits.peek()];
    if (first.length == 0 || first.symbol > 15) return false;
    bits.skip(first.length);
    bits.peek();
    bits.skip(first.symbol);
    for (int k = 1; k < 64; ++k) {
      const Code code = ac[bits.peek()];
      if (code.length == 0) return false;
      bits.skip(code.length);
      const int zeros = code.symbol >> 4, size = code.symbol & 15;
      if (size == 0 && zeros < 15) break;
      k += zeros;
      if (k > 63) return false;
      bits.peek();
      bits.skip(size);
    }
    return true;
  }

  // To the next marker that is none of a restart.
  bool skip_scan() {
    for (; end_ - at_ >= 2; ++at_) {
      if (at_[0] == 0xff && at_[1] != 0 && at_[1] != 0xff && (at_[1] & 0xf8) != first_restart) {
        return true;
      }
    }
    return false;
  }

  const std::uint8_t* at_;
  const std::uint8_t* end_;
  std::uint8_t marker_ = 0;
  bool has_scan_ = false, is_huffman_ = false;
  int interval_ = 0;
  int width_ = 0, height_ = 0;
  std::vector<Component> components_;
  std::array<Codes, 8> tables_;  // four of DC, four of AC
};

}  // namespace

bool is_whole_jpeg(const std::uint8_t* data, std::size_t size) {
  return Walk(data, size).is_whole();
}

}  // namespace robsim
