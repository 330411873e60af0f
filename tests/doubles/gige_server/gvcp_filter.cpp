#include "gige_server/gvcp_filter.hpp"

#ifdef __linux__

#include <arpa/inet.h>
#include <dirent.h>
#include <linux/filter.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cstddef>
#include <cstdlib>
#include <vector>

#include "robsim/capture/gige/discovery.hpp"

namespace robsim {

namespace {

// Offsets in a datagram, whose header of UDP a filter sees, too.
constexpr std::uint32_t key = 8, command = 10, length = 12, address = 16, value = 20, low_half = 22;
constexpr std::uint32_t headers = 16;  // bytes, of UDP and GVCP

enum Command : std::uint32_t {
  to_discover = 0x02,
  to_read_register = 0x80,
  to_write_register = 0x82,
  to_read_memory = 0x84
};

// Registers, and what they may be set to.
constexpr std::uint32_t last_register = 0xFFF8;
constexpr std::uint32_t first_setting = 0x100, last_setting = 0xDFC;
constexpr std::uint32_t description = 0x200, bootstrap = 0x900;  // what lies between stays
constexpr std::uint32_t width = 0x100, height = 0x104, frame_period = 0x138, packet_size = 0xD04;
constexpr std::uint32_t most_pixels = 2048;     // px
constexpr std::uint32_t smallest_packet = 128;  // bytes
constexpr std::uint32_t longest_answer = 536;   // bytes, of GVCP

// A program of the Berkeley packet filter: conditions, of which each one that fails drops a packet.
class Program {
 public:
  void load(std::uint32_t size, std::uint32_t offset) { add(BPF_LD | size | BPF_ABS, offset); }
  void add(std::uint32_t code, std::uint32_t k = 0) {
    lines_.push_back(BPF_STMT(static_cast<std::uint16_t>(code), k));
  }
  void need(std::uint32_t comparison, std::uint32_t k) { branch(comparison, k, 1, 0), drop(); }
  void need_not(std::uint32_t comparison, std::uint32_t k) { branch(comparison, k, 0, 1), drop(); }
  void need_outside(std::uint32_t low, std::uint32_t high) {
    branch(BPF_JGE | BPF_K, high, 2, 0);
    need_not(BPF_JGE | BPF_K, low);
  }
  void accept() { add(BPF_RET | BPF_K, 0xFFFFFFFF); }
  void drop() { add(BPF_RET | BPF_K, 0); }

  // What follows up to `end` is for packets with this number in the accumulator alone.
  std::size_t begin_if(std::uint32_t k) {
    branch(BPF_JEQ, k, 0, 0);
    return lines_.size();
  }
  void end(std::size_t begin) {
    lines_[begin - 1].jf = static_cast<std::uint8_t>(lines_.size() - begin);
  }

  void attach(int descriptor) {
    const sock_fprog program{static_cast<unsigned short>(lines_.size()), lines_.data()};
    setsockopt(descriptor, SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof program);
  }

 private:
  void branch(std::uint32_t comparison, std::uint32_t k, std::uint8_t yes, std::uint8_t no) {
    lines_.push_back(BPF_JUMP(static_cast<std::uint16_t>(BPF_JMP | comparison), k, yes, no));
  }

  std::vector<sock_filter> lines_;
};

void add_read_register(Program& program) {
  program.load(BPF_H, length);
  program.need(BPF_JEQ | BPF_K, 4);
  program.load(BPF_W, address);
  program.need_not(BPF_JGT | BPF_K, last_register);
  program.accept();
}

void add_read_memory(Program& program, std::uint32_t memory_end) {
  program.load(BPF_H, length);
  program.need(BPF_JEQ | BPF_K, 8);
  program.load(BPF_H, low_half);
  program.need_not(BPF_JEQ | BPF_K, 0);
  program.need_not(BPF_JGT | BPF_K, longest_answer);
  program.load(BPF_W, address);
  program.need_not(BPF_JGE | BPF_K, memory_end);
  program.accept();
}

void add_write_register(Program& program) {
  program.load(BPF_H, length);
  program.need(BPF_JEQ | BPF_K, 8);
  program.load(BPF_W, address);
  program.need(BPF_JGE | BPF_K, first_setting);
  program.need_not(BPF_JGT | BPF_K, last_setting);
  program.need_outside(description, bootstrap);
  for (const std::uint32_t side : {width, height}) {
    const std::size_t here = program.begin_if(side);
    program.load(BPF_W, value);
    program.need_not(BPF_JEQ | BPF_K, 0);
    program.need_not(BPF_JGT | BPF_K, most_pixels);
    program.accept();
    program.end(here);
  }
  const std::size_t period = program.begin_if(frame_period);
  program.load(BPF_W, value);
  program.need_not(BPF_JEQ | BPF_K, 0);
  program.accept();
  program.end(period);
  const std::size_t packets = program.begin_if(packet_size);
  program.load(BPF_H, low_half);
  program.need(BPF_JGE | BPF_K, smallest_packet);
  program.accept();
  program.end(packets);
  program.accept();
}

Program program_for(std::uint32_t memory_end) {
  Program program;
  program.load(BPF_B, key);
  program.need(BPF_JEQ | BPF_K, 0x42);
  // It is as long as it says.
  program.load(BPF_H, length);
  program.add(BPF_ALU | BPF_ADD | BPF_K, headers);
  program.add(BPF_MISC | BPF_TAX);
  program.add(BPF_LD | BPF_W | BPF_LEN);
  program.need(BPF_JEQ | BPF_X, 0);
  program.load(BPF_H, command);
  std::size_t here = program.begin_if(to_discover);
  program.accept();
  program.end(here);
  here = program.begin_if(to_read_register);
  add_read_register(program);
  program.end(here);
  here = program.begin_if(to_write_register);
  add_write_register(program);
  program.end(here);
  here = program.begin_if(to_read_memory);
  add_read_memory(program, memory_end);
  program.end(here);
  program.drop();
  return program;
}

bool is_control_socket(int descriptor) {
  sockaddr_in bound{};
  socklen_t size = sizeof bound;
  return getsockname(descriptor, reinterpret_cast<sockaddr*>(&bound), &size) == 0 &&
         bound.sin_family == AF_INET && ntohs(bound.sin_port) == gvcp_port;
}

}  // namespace

void filter_control_packets(std::uint32_t memory_end) {
  DIR* const directory = opendir("/proc/self/fd");
  if (!directory) return;
  Program program = program_for(memory_end);
  while (const dirent* entry = readdir(directory)) {
    const int descriptor = std::atoi(entry->d_name);
    if (entry->d_name[0] != '.' && is_control_socket(descriptor)) program.attach(descriptor);
  }
  closedir(directory);
}

}  // namespace robsim

#else

namespace robsim {

void filter_control_packets(std::uint32_t) {}

}  // namespace robsim

#endif
