#include "virtual_bus/iidc_registers.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "virtual_bus/iidc_features.hpp"
#include "virtual_bus/register_bits.hpp"

namespace robsim::virtual_bus {

namespace {

// Addresses. Those of the control registers are counted from `control_base`.
constexpr std::uint64_t rom_base = 0x400, rom_end = 0x800;
constexpr std::uint64_t control_base = 0xF00000, control_size = 0x900;
constexpr std::uint64_t inquiry_base = control_base + 0x404, inquiry_size = 0x17C;  // of features
constexpr std::uint64_t format7_base = 0xF10000, format7_size = 0x80;
constexpr std::uint64_t absolute_size = 0x400;

enum Control : std::uint64_t {
  initialize = 0x000,
  format_inquiry = 0x100,
  mode_inquiry = 0x180,
  rate_inquiry = 0x200,
  format7_inquiry = 0x2E0,
  basic_function_inquiry = 0x400,
  frame_rate = 0x600,
  video_mode = 0x604,
  video_format = 0x608,
  iso_data = 0x60C,
  power = 0x610,
  iso_enable = 0x614,
  data_depth = 0x630
};

enum Format7 : std::uint64_t {
  max_size = 0x00,
  unit_size = 0x04,
  position = 0x08,
  size = 0x0C,
  coding_id = 0x10,
  coding_inquiry = 0x14,
  pixel_number = 0x34,
  total_bytes_high = 0x38,
  total_bytes_low = 0x3C,
  packet_parameters = 0x40,
  bytes_per_packet = 0x44,
  packets_per_frame = 0x48,
  unit_position = 0x4C,
  frame_interval = 0x50,
  format7_depth = 0x54,
  filter_id = 0x58,
  value_setting = 0x7C
};

constexpr int format7 = 7;
constexpr int unit_width = 8, unit_height = 2, unit_step = 2;  // px
constexpr double cycles = 8000;                                // 1/s, of the bus

// A mode of the formats 0 to 2: IIDC 1.31, 2.1.
struct Mode {
  int format, mode, width, height;
  Coding coding;
};

constexpr std::array<Mode, 22> modes{
    {{0, 0, 160, 120, Coding::yuv444},   {0, 1, 320, 240, Coding::yuv422},
     {0, 2, 640, 480, Coding::yuv411},   {0, 3, 640, 480, Coding::yuv422},
     {0, 4, 640, 480, Coding::rgb8},     {0, 5, 640, 480, Coding::mono8},
     {0, 6, 640, 480, Coding::mono16},   {1, 0, 800, 600, Coding::yuv422},
     {1, 1, 800, 600, Coding::rgb8},     {1, 2, 800, 600, Coding::mono8},
     {1, 3, 1024, 768, Coding::yuv422},  {1, 4, 1024, 768, Coding::rgb8},
     {1, 5, 1024, 768, Coding::mono8},   {1, 6, 800, 600, Coding::mono16},
     {1, 7, 1024, 768, Coding::mono16},  {2, 0, 1280, 960, Coding::yuv422},
     {2, 1, 1280, 960, Coding::rgb8},    {2, 2, 1280, 960, Coding::mono8},
     {2, 3, 1600, 1200, Coding::yuv422}, {2, 4, 1600, 1200, Coding::rgb8},
     {2, 5, 1600, 1200, Coding::mono8},  {2, 6, 1280, 960, Coding::mono16}}};

int bits_of(Coding coding) {
  switch (coding) {
    case Coding::yuv411:
      return 12;
    case Coding::yuv422:
    case Coding::mono16:
      return 16;
    case Coding::yuv444:
    case Coding::rgb8:
      return 24;
    default:
      return 8;
  }
}

bool has(const CameraState& camera, Coding coding) {
  return camera.codings >> static_cast<std::uint32_t>(coding) & 1;
}

bool has(const CameraState& camera, const Mode& mode) {
  return mode.width == camera.width && mode.height == camera.height && has(camera, mode.coding);
}

double rate_of(std::uint32_t index) { return 1.875 * std::pow(2.0, index); }

int most_packet_bytes(std::uint32_t speed) { return 1024 << speed; }

// Whole fractions of lines go into a packet: 240 packets a frame at 30 frames/s, 256 of 768 lines.
int packet_bytes(const Mode& mode, double rate) {
  const double n_packets = (mode.height == 768 ? 256 : 240) * 30 / rate;
  return static_cast<int>(mode.width * mode.height * bits_of(mode.coding) / 8 / n_packets);
}

std::uint32_t iso_speed(const CameraState& camera) {
  const std::uint32_t data = camera.control[iso_data / 4];
  return data & 0x8000 ? data & 7 : data >> 24 & 3;
}

std::uint32_t rates_of(const CameraState& camera, const Mode& mode) {
  std::uint32_t found = 0;
  for (std::uint32_t index = 0; index < 6; ++index) {
    const double rate = rate_of(index);
    const bool fits = packet_bytes(mode, rate) <= most_packet_bytes(camera.speed);
    if (fits && rate <= 1.001 * camera.fps) found |= on >> index;
  }
  return found;
}

std::uint32_t formats_of(const CameraState& camera) {
  std::uint32_t found = on >> format7;
  for (const Mode& mode : modes) {
    if (has(camera, mode) && rates_of(camera, mode)) found |= on >> mode.format;
  }
  return found;
}

std::uint32_t modes_of(const CameraState& camera, std::uint64_t format) {
  if (format == format7) return on;  // mode 0 alone
  std::uint32_t found = 0;
  for (const Mode& mode : modes) {
    const bool is_asked = static_cast<std::uint64_t>(mode.format) == format;
    if (is_asked && has(camera, mode) && rates_of(camera, mode)) found |= on >> mode.mode;
  }
  return found;
}

const Mode* mode_of(std::uint32_t format, std::uint32_t number) {
  for (const Mode& mode : modes) {
    if (mode.format == static_cast<int>(format) && mode.mode == static_cast<int>(number)) {
      return &mode;
    }
  }
  return nullptr;
}

std::uint32_t pair(int high, int low) {
  return static_cast<std::uint32_t>(high) << 16 | static_cast<std::uint32_t>(low);
}

int high_of(std::uint32_t value) { return static_cast<int>(value >> 16); }
int low_of(std::uint32_t value) { return static_cast<int>(value & 0xFFFF); }

// What format 7 has chosen.
struct Region {
  int left, top, width, height;
  Coding coding;
  int total, packet, n_packets;
  double interval;  // s
  int every;
};

Region region_of(const CameraState& camera) {
  const auto& registers = camera.format7;
  Region region;
  region.left = high_of(registers[position / 4]);
  region.top = low_of(registers[position / 4]);
  region.width = high_of(registers[size / 4]);
  region.height = low_of(registers[size / 4]);
  region.coding = static_cast<Coding>(registers[coding_id / 4] >> 24);
  region.total = region.width * region.height * bits_of(region.coding) / 8;
  region.packet = std::max(4, high_of(registers[bytes_per_packet / 4]));
  region.n_packets = std::max(1, (region.total + region.packet - 1) / region.packet);
  // The bus carries a frame in n_packets cycles, and the sensor gives one in 1 / fps.
  region.every =
      std::max(1, static_cast<int>(std::ceil(region.n_packets / cycles * camera.fps - 1e-6)));
  region.interval = region.every / camera.fps;
  return region;
}

int recommended_packet(const CameraState& camera) {
  const Region region = region_of(camera);
  const int units = static_cast<int>(std::ceil(region.total * camera.fps / cycles / 4));
  return std::clamp(4 * units, 4, most_packet_bytes(iso_speed(camera)));
}

bool is_region_valid(const CameraState& camera) {
  const Region r = region_of(camera);
  return r.width > 0 && r.height > 0 && r.width % unit_width == 0 && r.height % unit_height == 0 &&
         r.left % unit_step == 0 && r.top % unit_step == 0 && r.left + r.width <= camera.width &&
         r.top + r.height <= camera.height && has(camera, r.coding);
}

bool is_packet_valid(const CameraState& camera) {
  const int bytes = high_of(camera.format7[bytes_per_packet / 4]);
  return bytes >= 4 && bytes % 4 == 0 && bytes <= most_packet_bytes(iso_speed(camera));
}

// As the camera says it.
int told_packets(const CameraState& camera, const Region& region) {
  return camera.is_short ? (region.n_packets + 1) / 2 : region.n_packets;
}

std::uint32_t read_format7(const CameraState& camera, std::uint64_t offset) {
  const Region region = region_of(camera);
  switch (offset) {
    case max_size:
      return pair(camera.width, camera.height);
    case unit_size:
      return pair(unit_width, unit_height);
    case unit_position:
      return pair(unit_step, unit_step);
    case coding_inquiry: {
      std::uint32_t found = 0;
      for (std::uint32_t number = 0; number < 11; ++number) {
        if (camera.codings >> number & 1) found |= on >> number;
      }
      return found;
    }
    case pixel_number:
      return static_cast<std::uint32_t>(region.width * region.height);
    case total_bytes_high:
      return 0;
    case total_bytes_low:
      return static_cast<std::uint32_t>(region.packet * told_packets(camera, region));
    case packet_parameters:
      return pair(4, most_packet_bytes(iso_speed(camera)));
    case bytes_per_packet:
      return camera.format7[offset / 4] | static_cast<std::uint32_t>(recommended_packet(camera));
    case packets_per_frame:
      return static_cast<std::uint32_t>(told_packets(camera, region));
    case frame_interval:
      return bits_of_float(region.interval);
    case format7_depth:
      return (region.coding == Coding::mono16 ? 16u : 8u) << 24;
    case filter_id:
      return camera.color_filter << 24;
    case value_setting:
      return on | (is_region_valid(camera) ? 0 : 1u << 23) |
             (is_packet_valid(camera) ? 0 : 1u << 22);
    default:
      return camera.format7[offset / 4];
  }
}

void write_format7(CameraState& camera, std::uint64_t offset, std::uint32_t value) {
  if (offset == bytes_per_packet) value &= 0xFFFF0000;
  if (offset == position || offset == size || offset == coding_id || offset == bytes_per_packet) {
    camera.format7[offset / 4] = value;
  }
}

bool sends_mono16(const CameraState& camera) {
  const std::uint32_t format = camera.control[video_format / 4] >> 29;
  if (format == format7) return region_of(camera).coding == Coding::mono16;
  const Mode* mode = mode_of(format, camera.control[video_mode / 4] >> 29);
  return mode && mode->coding == Coding::mono16;
}

std::uint32_t read_control(const CameraState& camera, std::uint64_t offset) {
  if (offset == format_inquiry) return formats_of(camera);
  if (offset >= mode_inquiry && offset < mode_inquiry + 0x20) {
    return modes_of(camera, (offset - mode_inquiry) / 4);
  }
  if (offset >= rate_inquiry && offset < rate_inquiry + 0x60) {
    const auto place = static_cast<std::uint32_t>(offset - rate_inquiry) / 4;
    const Mode* mode = mode_of(place / 8, place % 8);
    return mode && has(camera, *mode) ? rates_of(camera, *mode) : 0;
  }
  if (offset == format7_inquiry) return format7_base / 4;
  if (offset == basic_function_inquiry) return camera.speed > 2 ? 1u << 23 : 0;
  if (const auto value = read_feature(camera, offset)) return *value;
  if (offset == data_depth) return (sends_mono16(camera) ? 16u : 8u) << 24;
  return camera.control[offset / 4];
}

void write_control(CameraState& camera, std::uint64_t offset, std::uint32_t value) {
  if (offset == initialize) {
    if (value & on) power_on(camera);
  } else if (!write_feature(camera, offset, value) && offset >= frame_rate &&
             offset <= iso_enable) {
    camera.control[offset / 4] = value;
  }
}

bool is_in(std::uint64_t address, std::uint64_t base, std::uint64_t length) {
  return address >= base && address < base + length;
}

}  // namespace

std::optional<std::uint32_t> read_register(CameraState& camera, std::uint64_t address) {
  if (address % 4) return std::nullopt;
  if (camera.is_plain && is_in(address, inquiry_base, inquiry_size)) return std::nullopt;
  if (is_in(address, rom_base, rom_end - rom_base)) {
    const std::vector<std::uint32_t> rom = config_rom_of(camera);
    const std::size_t place = (address - rom_base) / 4;
    return place < rom.size() ? rom[place] : 0;
  }
  if (is_in(address, control_base, control_size))
    return read_control(camera, address - control_base);
  if (is_in(address, format7_base, format7_size))
    return read_format7(camera, address - format7_base);
  if (is_in(address, absolute_base, absolute_size))
    return read_absolute(camera, address - absolute_base);
  return std::nullopt;
}

bool write_register(CameraState& camera, std::uint64_t address, std::uint32_t value) {
  if (address % 4) return false;
  if (is_in(address, control_base, control_size)) {
    write_control(camera, address - control_base, value);
  } else if (is_in(address, format7_base, format7_size)) {
    write_format7(camera, address - format7_base, value);
  } else {
    return is_in(address, absolute_base, absolute_size) &&
           write_absolute(camera, address - absolute_base, value);
  }
  return true;
}

void power_on(CameraState& camera) {
  camera.control.fill(0);
  camera.format7.fill(0);
  camera.control[power / 4] = on;
  camera.control[iso_data / 4] = 2u << 24;  // S400
  power_features_on(camera);
  camera.format7[size / 4] = pair(camera.width, camera.height);
  std::uint32_t first = 0;
  while (first < 11 && !(camera.codings >> first & 1)) ++first;
  camera.format7[coding_id / 4] = first << 24;
  camera.format7[bytes_per_packet / 4] = static_cast<std::uint32_t>(recommended_packet(camera))
                                         << 16;
  std::uint32_t format = 0;
  while (!(formats_of(camera) & on >> format)) ++format;
  camera.control[video_format / 4] = format << 29;
  std::uint32_t mode = 0;
  while (!(modes_of(camera, format) & on >> mode)) ++mode;
  camera.control[video_mode / 4] = mode << 29;
  camera.is_on = true;
}

void stop_transmission(CameraState& camera) { camera.control[iso_enable / 4] = 0; }

Transmission transmission_of(CameraState& camera) {
  const std::uint32_t data = camera.control[iso_data / 4];
  Transmission sent;
  sent.is_on = camera.control[iso_enable / 4] & on;
  sent.speed = iso_speed(camera);
  sent.channel = static_cast<int>(data & 0x8000 ? data >> 8 & 0x3F : data >> 28);
  const std::uint32_t format = camera.control[video_format / 4] >> 29;
  if (format == format7) {
    const Region region = region_of(camera);
    sent.is_on = sent.is_on && is_region_valid(camera) && is_packet_valid(camera);
    sent.coding = region.coding;
    sent.left = region.left;
    sent.top = region.top;
    sent.width = region.width;
    sent.height = region.height;
    sent.packet_bytes = region.packet;
    sent.n_packets = region.n_packets;
    sent.every = region.every;
    return sent;
  }
  const Mode* mode = mode_of(format, camera.control[video_mode / 4] >> 29);
  const std::uint32_t rate = camera.control[frame_rate / 4] >> 29;
  if (!mode || !has(camera, *mode) || !(rates_of(camera, *mode) & on >> rate)) {
    sent.is_on = false;
    return sent;
  }
  sent.coding = mode->coding;
  sent.width = mode->width;
  sent.height = mode->height;
  sent.packet_bytes = packet_bytes(*mode, rate_of(rate));
  sent.n_packets = mode->width * mode->height * bits_of(mode->coding) / 8 / sent.packet_bytes;
  sent.every = std::max(1, static_cast<int>(std::lround(camera.fps / rate_of(rate))));
  sent.is_on = sent.is_on && sent.packet_bytes <= most_packet_bytes(iso_speed(camera));
  return sent;
}

}  // namespace robsim::virtual_bus
