#include "robsim/simulation/remote/shared_frames.hpp"

#include <cerrno>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <system_error>

#ifndef _WIN32
#include <sys/mman.h>
#endif

namespace robsim {

SharedFrames::SharedFrames(int descriptor, int slots, std::size_t slot_bytes, int width, int height)
    : descriptor_(descriptor),
      slot_bytes_(slot_bytes),
      width_(width),
      height_(height),
      images_(static_cast<std::size_t>(slots)) {
  if (slots < 1 || width < 1 || height < 1 ||
      slot_bytes <
          std::size_t{3} * static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {
    throw std::invalid_argument("every slot must have room for a frame");
  }
  for (int slot = 0; slot < slots; ++slot) image(slot);
}

#ifdef _WIN32

Image SharedFrames::image(int) { throw std::runtime_error("this system has no shared frames"); }

int SharedFrames::free_beside(int slot) { return slot; }

void SharedFrames::let_go(Image&) {}

#else

namespace {

#ifdef MAP_POPULATE
constexpr int all_at_once = MAP_POPULATE;  // all pages: one by one they take longer than the copy
#else
constexpr int all_at_once = 0;
#endif

void* mapped(void* at, std::size_t size, int protection, int flags, int descriptor, off_t offset) {
  void* const memory = ::mmap(at, size, protection, flags, descriptor, offset);
  if (memory != MAP_FAILED) return memory;
  throw std::system_error(errno, std::generic_category(), "the frames cannot be mapped");
}

// Puts memory of this process in the place of shared one, with the same content.
void make_private(void* memory, std::size_t size) {
  constexpr int own = MAP_PRIVATE | MAP_ANONYMOUS | all_at_once;
  void* const copy = mapped(nullptr, size, PROT_READ | PROT_WRITE, own, -1, 0);
  std::memcpy(copy, memory, size);
#ifdef __linux__
  ::mprotect(copy, size, PROT_READ);
  // At once, for who reads it meanwhile.
  if (::mremap(copy, size, size, MREMAP_MAYMOVE | MREMAP_FIXED, memory) == MAP_FAILED) {
    throw std::system_error(errno, std::generic_category(), "a frame that is held cannot be kept");
  }
#else
  mapped(memory, size, PROT_READ | PROT_WRITE, own | MAP_FIXED, -1, 0);
  std::memcpy(memory, copy, size);
  ::mprotect(memory, size, PROT_READ);
  ::munmap(copy, size);
#endif
}

}  // namespace

Image SharedFrames::image(int slot) {
  Image& known = images_.at(static_cast<std::size_t>(slot));
  if (known.empty()) {
    const std::size_t size = slot_bytes_;
    void* const memory = mapped(nullptr, size, PROT_READ, MAP_SHARED | all_at_once, descriptor_,
                                static_cast<off_t>(static_cast<std::size_t>(slot) * size));
    const std::shared_ptr<void> owner(memory, [size](void* p) { ::munmap(p, size); });
    const ImageView view{static_cast<const std::uint8_t*>(memory), width_, height_,
                         std::ptrdiff_t{3} * width_};
    known = Image(view, owner);
  }
  return known;
}

int SharedFrames::free_beside(int slot) {
  const int count = static_cast<int>(images_.size());
  for (int other = 0; other < count; ++other) {
    if (other != slot && !images_[static_cast<std::size_t>(other)].is_shared()) return other;
  }
  const int next = (slot + 1) % count;
  let_go(images_[static_cast<std::size_t>(next)]);
  return next;
}

void SharedFrames::let_go(Image& image) {
  if (image.empty() || !image.is_shared()) return;
  make_private(const_cast<std::uint8_t*>(image.row(0)), slot_bytes_);
  image = Image();
}

#endif

}  // namespace robsim
