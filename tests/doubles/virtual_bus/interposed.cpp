// The functions of the C library through which libdc1394 reaches the kernel. What is not of the
// virtual bus goes on to the next library.

// These would have the headers give open, read and others bodies or names of their own, and some
// compilers set them.
#undef _FORTIFY_SOURCE
#undef _FILE_OFFSET_BITS

#include <dirent.h>
#include <fcntl.h>
#include <stdarg.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "virtual_bus/attached_bus.hpp"
#include "virtual_bus/device_file.hpp"
#include "virtual_bus/system_calls.hpp"

#define INTERPOSED extern "C" __attribute__((visibility("default")))

using robsim::virtual_bus::attached_bus;
using robsim::virtual_bus::BusMemory;
using robsim::virtual_bus::DeviceFile;
using robsim::virtual_bus::is_there;
using robsim::virtual_bus::node_of;
using robsim::virtual_bus::real;

namespace robsim::virtual_bus {

int real_open(const char* path, int flags, unsigned mode) {
  static auto* const next = real<int(const char*, int, ...)>("open");
  return next(path, flags, mode);
}

int real_close(int descriptor) {
  static auto* const next = real<int(int)>("close");
  return next(descriptor);
}

}  // namespace robsim::virtual_bus

namespace {

using robsim::virtual_bus::real_close;
using robsim::virtual_bus::real_open;

constexpr int most_files = 4096;
constexpr int queued_bytes = 4 << 20;  // of events that nobody has read

// The open files of the bus, by their descriptors. Never destroyed: libraries close files late.
struct Files {
  std::array<std::atomic<bool>, most_files> is_ours{};
  std::mutex mutex;
  std::map<int, std::shared_ptr<DeviceFile>> open;
};

Files& files() {
  static Files* const all = new Files;
  return *all;
}

bool is_ours(int descriptor) {
  return descriptor >= 0 && descriptor < most_files &&
         files().is_ours[static_cast<std::size_t>(descriptor)];
}

std::shared_ptr<DeviceFile> file_of(int descriptor) {
  if (!is_ours(descriptor)) return nullptr;
  const std::lock_guard<std::mutex> lock(files().mutex);
  const auto found = files().open.find(descriptor);
  return found == files().open.end() ? nullptr : found->second;
}

int fail(int error) {
  errno = error;
  return -1;
}

// Number of an error, 0 if whoever asks may have the node.
int refusal_of(const BusMemory& bus, int node) {
  if (!is_there(bus, node)) return ENOENT;
  return node > 0 && bus.cameras[static_cast<std::size_t>(node - 1)].is_denied ? EACCES : 0;
}

int open_node(BusMemory& bus, int node) {
  if (const int error = refusal_of(bus, node)) return fail(error);
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) < 0) return -1;
  if (ends[0] >= most_files) {
    real_close(ends[0]);
    real_close(ends[1]);
    return fail(EMFILE);
  }
  setsockopt(ends[1], SOL_SOCKET, SO_SNDBUF, &queued_bytes, sizeof queued_bytes);
  const std::lock_guard<std::mutex> lock(files().mutex);
  files().open[ends[0]] = std::make_shared<DeviceFile>(bus, node, ends[1]);
  files().is_ours[static_cast<std::size_t>(ends[0])] = true;
  return ends[0];
}

// -2: the path is none of the bus.
int try_open(const char* path) {
  if (std::strncmp(path, "/dev/fw", 7) != 0) return -2;
  BusMemory* const bus = attached_bus();
  if (!bus) return -2;
  const int node = node_of(*bus, path);
  return node < 0 ? fail(ENOENT) : open_node(*bus, node);
}

// Directories that are being read: "/dev" gets the nodes of the bus after its own entries.
struct Listing {
  int next = 0;
  dirent entry{};
};

struct Listings {
  std::mutex mutex;
  std::map<DIR*, Listing> open;
};

Listings& listings() {
  static Listings* const all = new Listings;
  return *all;
}

bool is_fire_wire(const char* name) {
  return std::strncmp(name, "fw", 2) == 0 && name[2] >= '0' && name[2] <= '9';
}

dirent* next_entry(DIR* directory, dirent* (*next)(DIR*)) {
  {
    const std::lock_guard<std::mutex> lock(listings().mutex);
    if (!listings().open.count(directory)) return next(directory);
  }
  while (dirent* entry = next(directory)) {
    if (!is_fire_wire(entry->d_name)) return entry;
  }
  BusMemory* const bus = attached_bus();
  const std::lock_guard<std::mutex> lock(listings().mutex);
  const auto found = listings().open.find(directory);
  if (!bus || found == listings().open.end()) return nullptr;
  Listing& listing = found->second;
  while (listing.next <= bus->n_cameras && !is_there(*bus, listing.next)) ++listing.next;
  if (listing.next > bus->n_cameras) return nullptr;
  listing.entry.d_type = DT_CHR;
  listing.entry.d_ino = 1;
  listing.entry.d_reclen = sizeof(dirent);
  std::snprintf(listing.entry.d_name, sizeof listing.entry.d_name, "fw%d", listing.next++);
  return &listing.entry;
}

void* map_file(std::size_t length) {
  static auto* const next = real<decltype(::mmap)>("mmap");
  return next(nullptr, length, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
}

}  // namespace

/// Says that the library is there: what loads it without a word may as well have missed it.
INTERPOSED int robsim_virtual_bus_is_there() { return 1; }

INTERPOSED int open(const char* path, int flags, ...) {
  const int ours = try_open(path);
  if (ours != -2) return ours;
  va_list arguments;
  va_start(arguments, flags);
  const unsigned mode = flags & (O_CREAT | __O_TMPFILE) ? va_arg(arguments, unsigned) : 0;
  va_end(arguments);
  return real_open(path, flags, mode);
}

INTERPOSED int open64(const char* path, int flags, ...) {
  const int ours = try_open(path);
  if (ours != -2) return ours;
  va_list arguments;
  va_start(arguments, flags);
  const unsigned mode = flags & (O_CREAT | __O_TMPFILE) ? va_arg(arguments, unsigned) : 0;
  va_end(arguments);
  static auto* const next = real<int(const char*, int, ...)>("open64");
  return next(path, flags, mode);
}

// What programs call that were built with _FORTIFY_SOURCE.
INTERPOSED int __open_2(const char* path, int flags) { return open(path, flags); }

INTERPOSED int __open64_2(const char* path, int flags) { return open64(path, flags); }

INTERPOSED int access(const char* path, int mode) noexcept {
  if (std::strncmp(path, "/dev/fw", 7) == 0) {
    if (const BusMemory* const bus = attached_bus()) {
      const int node = node_of(*bus, path);
      const int error = node < 0 ? ENOENT : refusal_of(*bus, node);
      return error ? fail(error) : 0;
    }
  }
  static auto* const next = real<int(const char*, int)>("access");
  return next(path, mode);
}

INTERPOSED int close(int descriptor) {
  if (is_ours(descriptor)) {
    std::shared_ptr<DeviceFile> file;
    const std::lock_guard<std::mutex> lock(files().mutex);
    const auto found = files().open.find(descriptor);
    if (found != files().open.end()) {
      file = std::move(found->second);
      files().open.erase(found);
      files().is_ours[static_cast<std::size_t>(descriptor)] = false;
    }
  }
  return real_close(descriptor);
}

INTERPOSED ssize_t read(int descriptor, void* to, std::size_t size) {
  static auto* const next = real<ssize_t(int, void*, std::size_t)>("read");
  if (!is_ours(descriptor)) return next(descriptor, to, size);
  const auto file = file_of(descriptor);
  if (file && !file->is_alive()) return fail(ENODEV);
  const ssize_t result = next(descriptor, to, size);
  if (file) file->has_been_read();
  return result == 0 ? fail(ENODEV) : result;
}

INTERPOSED ssize_t __read_chk(int descriptor, void* to, std::size_t size, std::size_t) {
  return read(descriptor, to, size);
}

INTERPOSED int ioctl(int descriptor, unsigned long request, ...) noexcept {
  va_list arguments;
  va_start(arguments, request);
  void* const argument = va_arg(arguments, void*);
  va_end(arguments);
  if (const auto file = file_of(descriptor)) {
    const int result = file->control(request, argument);
    return result < 0 ? fail(-result) : result;
  }
  static auto* const next = real<int(int, unsigned long, ...)>("ioctl");
  return next(descriptor, request, argument);
}

INTERPOSED void* mmap(void* address, std::size_t length, int protection, int flags, int descriptor,
                      off_t offset) noexcept {
  if (is_ours(descriptor)) return map_file(length);
  static auto* const next = real<decltype(::mmap)>("mmap");
  return next(address, length, protection, flags, descriptor, offset);
}

INTERPOSED void* mmap64(void* address, std::size_t length, int protection, int flags,
                        int descriptor, off64_t offset) noexcept {
  if (is_ours(descriptor)) return map_file(length);
  static auto* const next = real<decltype(::mmap64)>("mmap64");
  return next(address, length, protection, flags, descriptor, offset);
}

INTERPOSED DIR* opendir(const char* name) {
  static auto* const next = real<DIR*(const char*)>("opendir");
  DIR* const directory = next(name);
  const bool is_dev = std::strcmp(name, "/dev") == 0 || std::strcmp(name, "/dev/") == 0;
  if (directory && is_dev && attached_bus()) {
    const std::lock_guard<std::mutex> lock(listings().mutex);
    listings().open[directory] = {};
  }
  return directory;
}

INTERPOSED dirent* readdir(DIR* directory) {
  static auto* const next = real<dirent*(DIR*)>("readdir");
  return next_entry(directory, next);
}

INTERPOSED dirent64* readdir64(DIR* directory) {
  // The same structure where off_t has 64 bits.
  static_assert(sizeof(dirent) == sizeof(dirent64));
  static auto* const next = real<dirent*(DIR*)>("readdir64");
  return reinterpret_cast<dirent64*>(next_entry(directory, next));
}

INTERPOSED int closedir(DIR* directory) {
  {
    const std::lock_guard<std::mutex> lock(listings().mutex);
    listings().open.erase(directory);
  }
  static auto* const next = real<int(DIR*)>("closedir");
  return next(directory);
}
