#include "virtual_bus/iidc_features.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "virtual_bus/register_bits.hpp"

namespace robsim::virtual_bus {

namespace {

// Offsets among the control registers; a block has a register for each feature.
constexpr std::uint64_t feature_inquiry = 0x404;
constexpr std::uint64_t element_inquiry = 0x500, absolute_inquiry = 0x700, values = 0x800;
constexpr std::uint64_t block_size = 0x80, absolute_size = 0x10;

// Bits of the inquiry registers, and of the values.
constexpr std::uint32_t present = on, absolute = 1u << 30, readable = 1u << 27,
                        can_be_automatic = 1u << 25, can_be_manual = 1u << 24;
constexpr std::uint32_t is_enabled = 1u << 25, is_automatic = 1u << 24;

struct Feature {
  std::uint32_t index;  // place in a block
  std::uint32_t low, high, start;
  double unit;  // of the absolute value; 0: it has none
};

enum FeatureIndex { brightness = 0, exposure = 1, white_balance = 3, shutter = 7, gain = 8 };
constexpr double shutter_unit = 1e-5;  // s
constexpr double gain_unit = 0.05;     // dB
constexpr std::uint32_t start_shutter = 1000, start_gain = 0, start_balance = 512;

constexpr std::array<Feature, 5> feature_table{{{brightness, 0, 255, 128, 0},
                                                {exposure, 0, 1023, 512, 0},
                                                {white_balance, 1, 1023, start_balance, 0},
                                                {shutter, 1, 4095, start_shutter, shutter_unit},
                                                {gain, 0, 480, start_gain, gain_unit}}};

std::uint32_t value_of(const CameraState& camera, std::uint32_t index) {
  return camera.control[values / 4 + index];
}

bool is_in_block(std::uint64_t offset, std::uint64_t base) {
  return offset >= base && offset < base + block_size;
}

// The one whose register lies there in a block.
const Feature* feature_at(std::uint64_t offset) {
  for (const Feature& feature : feature_table) {
    if (offset == 4 * std::uint64_t{feature.index}) return &feature;
  }
  return nullptr;
}

// The one whose absolute value, least or greatest one lies there.
const Feature* absolute_feature_at(std::uint64_t offset) {
  const bool is_value = offset % absolute_size < 12;
  const Feature* feature = feature_at(offset / absolute_size * 4);
  return feature && feature->unit > 0 && is_value ? feature : nullptr;
}

std::uint32_t all_features() {
  std::uint32_t found = 0;
  for (const Feature& feature : feature_table) found |= on >> feature.index;
  return found;
}

std::uint32_t elements_of(const Feature& feature) {
  return present | readable | can_be_automatic | can_be_manual | (feature.unit > 0 ? absolute : 0) |
         feature.low << 12 | feature.high;
}

}  // namespace

std::optional<std::uint32_t> read_feature(const CameraState& camera, std::uint64_t offset) {
  if (offset == feature_inquiry) return all_features();
  if (is_in_block(offset, element_inquiry)) {
    const Feature* feature = feature_at(offset - element_inquiry);
    return feature ? elements_of(*feature) : 0;
  }
  if (is_in_block(offset, absolute_inquiry)) {
    const Feature* feature = feature_at(offset - absolute_inquiry);
    if (!feature || feature->unit <= 0) return 0;
    return static_cast<std::uint32_t>((absolute_base + feature->index * absolute_size) / 4);
  }
  if (is_in_block(offset, values)) return camera.control[offset / 4];
  return std::nullopt;
}

bool write_feature(CameraState& camera, std::uint64_t offset, std::uint32_t value) {
  if (!is_in_block(offset, values)) return false;
  const Feature* feature = feature_at(offset - values);
  if (!feature) return true;  // as real cameras do: it stays 0
  const std::uint32_t kept = value & (absolute | is_automatic);
  std::uint32_t& place = camera.control[offset / 4];
  if (feature->index == white_balance) {
    place = present | is_enabled | kept | (value & 0xFFFFFF);
    return true;
  }
  // The absolute value rules the other while it is chosen.
  const std::uint32_t chosen =
      value & absolute ? place & 0xFFF : std::clamp(value & 0xFFF, feature->low, feature->high);
  place = present | is_enabled | kept | chosen;
  return true;
}

// Least, greatest, present value.
std::optional<std::uint32_t> read_absolute(const CameraState& camera, std::uint64_t offset) {
  const Feature* feature = absolute_feature_at(offset);
  if (!feature) return std::nullopt;
  const std::uint64_t place = offset % absolute_size;
  const std::uint32_t now = value_of(camera, feature->index) & 0xFFF;
  const std::uint32_t raw = place == 0 ? feature->low : place == 4 ? feature->high : now;
  return bits_of_float(raw * feature->unit);
}

bool write_absolute(CameraState& camera, std::uint64_t offset, std::uint32_t value) {
  const Feature* feature = absolute_feature_at(offset);
  if (!feature) return false;
  std::uint32_t& place = camera.control[values / 4 + feature->index];
  if (offset % absolute_size != 8 || !(place & absolute)) return true;
  const double raw = std::round(float_of_bits(value) / feature->unit);
  const double bounded = std::fmax(feature->low, std::fmin(raw, feature->high));
  place = (place & ~0xFFFu) | static_cast<std::uint32_t>(bounded);
  return true;
}

void power_features_on(CameraState& camera) {
  for (const Feature& feature : feature_table) {
    const std::uint32_t value =
        feature.index == white_balance ? start_balance << 12 | start_balance : feature.start;
    camera.control[values / 4 + feature.index] = present | is_enabled | is_automatic | value;
  }
}

Brightness brightness_of(const CameraState& camera) {
  const std::uint32_t time = value_of(camera, shutter), amplified = value_of(camera, gain);
  double light = 1;
  if (!(time & is_automatic)) light *= (time & 0xFFF) / double{start_shutter};
  if (!(amplified & is_automatic)) {
    light *= std::pow(10.0, (amplified & 0xFFF) * gain_unit / 20);
  }
  Brightness result{light, light, light};
  const std::uint32_t balance = value_of(camera, white_balance);
  if (!(balance & is_automatic)) {
    result.red *= (balance & 0xFFF) / double{start_balance};
    result.blue *= (balance >> 12 & 0xFFF) / double{start_balance};
  }
  return result;
}

}  // namespace robsim::virtual_bus
