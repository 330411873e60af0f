#include <string>

#include "virtual_bus/iidc_registers.hpp"

namespace robsim::virtual_bus {

namespace {

using Quadlets = std::vector<std::uint32_t>;

constexpr std::uint32_t vendor = 0x00B05A;            // any number: no maker of cameras has it
constexpr std::uint32_t command_base = 0xF00000 / 4;  // as in iidc_registers.cpp

std::uint32_t entry(std::uint32_t key, std::uint32_t value) { return key << 24 | value; }

// A leaf of text: IEEE 1212, 7.5.4.1.
Quadlets text_leaf(const std::string& text) {
  const std::size_t words = (text.size() + 3) / 4;
  Quadlets leaf{static_cast<std::uint32_t>(words + 2) << 16, 0, 0};
  for (std::size_t word = 0; word < words; ++word) {
    std::uint32_t value = 0;
    for (std::size_t i = 4 * word; i < 4 * word + 4; ++i) {
      value = value << 8 | (i < text.size() ? static_cast<unsigned char>(text[i]) : 0u);
    }
    leaf.push_back(value);
  }
  return leaf;
}

void append(Quadlets& rom, const Quadlets& more) {
  rom.insert(rom.end(), more.begin(), more.end());
}

// The header of the ROM, and the bus information block.
Quadlets header(std::uint64_t guid) {
  return {4u << 24 | 4u << 16, 0x31333934,  // "1394"
          0x0000A002, static_cast<std::uint32_t>(guid >> 32), static_cast<std::uint32_t>(guid)};
}

}  // namespace

std::vector<std::uint32_t> config_rom_of(const CameraState& camera) {
  const Quadlets maker = text_leaf("robsim virtual bus");
  const Quadlets model = text_leaf("Simulated camera");
  Quadlets rom = header(camera.guid);
  // Root directory; offsets count from their own place.
  append(rom, {2u << 16, entry(0x03, vendor), entry(0xD1, 1)});
  // Unit directory: IIDC 1.31, 1.2.
  append(rom,
         {4u << 16, entry(0x12, 0x00A02D), entry(0x13, 0x000102), entry(0x17, 1), entry(0xD4, 1)});
  // Unit dependent directory.
  append(rom, {4u << 16, entry(0x40, command_base), entry(0x81, 3),
               entry(0x82, static_cast<std::uint32_t>(2 + maker.size())), entry(0x38, 0x10)});
  append(rom, maker);
  append(rom, model);
  return rom;
}

std::vector<std::uint32_t> config_rom_of_computer() {
  Quadlets rom = header(0x00B0'5A00'0000'0000);
  append(rom, {1u << 16, entry(0x03, vendor)});
  return rom;
}

}  // namespace robsim::virtual_bus
