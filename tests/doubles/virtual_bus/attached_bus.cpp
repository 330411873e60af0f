#include "virtual_bus/attached_bus.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include <cstdlib>
#include <cstring>
#include <map>
#include <mutex>

#include "virtual_bus/system_calls.hpp"

namespace robsim::virtual_bus {

namespace {

// Null if it cannot be mapped, or is no bus.
BusMemory* mapped(const char* path) {
  const int descriptor = real_open(path, O_RDWR | O_CLOEXEC);
  if (descriptor < 0) return nullptr;
  struct stat status{};
  void* memory = MAP_FAILED;
  std::size_t size = 0;
  if (fstat(descriptor, &status) == 0 && status.st_size >= static_cast<off_t>(sizeof(BusMemory))) {
    size = static_cast<std::size_t>(status.st_size);
    memory = real<decltype(::mmap)>("mmap")(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED,
                                            descriptor, 0);
  }
  real_close(descriptor);
  if (memory == MAP_FAILED) return nullptr;
  auto* bus = static_cast<BusMemory*>(memory);
  if (bus->magic == bus_magic && bus->size == size) return bus;
  munmap(memory, size);
  return nullptr;
}

}  // namespace

BusMemory* attached_bus() {
  const char* path = std::getenv(bus_variable);
  if (!path || !*path) return nullptr;
  // One mapping for each bus that a process ever looks at: files of it may be open for long.
  static std::mutex mutex;
  static auto* buses = new std::map<std::string, BusMemory*>;
  const std::lock_guard<std::mutex> lock(mutex);
  const auto known = buses->find(path);
  if (known != buses->end()) return known->second;
  BusMemory* bus = mapped(path);
  if (bus) buses->emplace(path, bus);
  return bus;
}

int node_of(const BusMemory& bus, const char* path) {
  constexpr const char* prefix = "/dev/fw";
  if (!path || std::strncmp(path, prefix, std::strlen(prefix)) != 0) return -1;
  const char* number = path + std::strlen(prefix);
  if (number[0] < '0' || number[0] > '9' || number[1]) return -1;
  const int node = number[0] - '0';
  return node <= bus.n_cameras ? node : -1;
}

bool is_there(const BusMemory& bus, int node) {
  return node == 0 || bus.cameras[static_cast<std::size_t>(node - 1)].is_plugged_in;
}

}  // namespace robsim::virtual_bus
