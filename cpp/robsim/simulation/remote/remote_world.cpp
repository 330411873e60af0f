#include "robsim/simulation/remote/remote_world.hpp"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "robsim/simulation/robot/stages.hpp"

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

namespace {

constexpr double not_known = std::numeric_limits<double>::quiet_NaN();

// Two of each colour, in the order of their names.
std::vector<Point> recorded_blobs(const BlobsByColor& blobs) {
  std::vector<Point> centroids;
  for (const auto& [color, found] : blobs) {
    for (std::size_t i = 0; i < 2; ++i) {
      centroids.push_back(i < found.size() ? found[i].centroid : Point{not_known, not_known});
    }
  }
  return centroids;
}

}  // namespace

Arrival RemoteWorld::next(std::int64_t k, Observation& observation) {
  if (message_.k < k && !take_step(k)) return Arrival::end;
  // A step in which nothing was to be done here, for want of a frame, comes without a message.
  const bool is_told = message_.k == k;
  observation.t = message_.t - static_cast<double>(message_.k - k) * dt_;
  observation.has_frame = is_told && message_.has_frame;
  if (!is_told) return Arrival::step;
  if (k > 0) observation.last_u = message_.last_u;
  observation.sample = message_.sample;
  if (message_.done & measure_bit) observation.measurement = message_.measurement;
  return Arrival::step;
}

// The next message: that of step k, or of a later one. False at the end.
bool RemoteWorld::take_step(std::int64_t k) {
  if (!ask(std::exchange(answer_, {}))) return false;
  if (message_.k < k) throw std::runtime_error("the grader has told of an earlier step");
  frame_.reset();
  return true;
}

bool RemoteWorld::ask(const std::string& answer) {
  std::optional<std::string> bytes = exchange_(answer);
  if (!bytes) return false;
  const std::size_t pixel_bytes = std::size_t{3} * static_cast<std::size_t>(options_.width) *
                                  static_cast<std::size_t>(options_.height);
  message_ = message_from(bytes->data(), bytes->size(), pixel_bytes);
  const bool has_pixels = message_.frame && message_.frame->slot < 0;
  if (has_pixels) pixels_ = bytes->substr(bytes->size() - pixel_bytes);
  return true;
}

Frame RemoteWorld::frame() {
  if (frame_) return *frame_;
  if (!message_.frame) throw std::runtime_error("the grader has sent no frame");
  const FrameMessage& told = *message_.frame;
  Frame frame;
  frame.t = told.t;
  frame.index = told.index;
  frame.headings = told.headings;
  frame.plane_map = told.plane_map;
  if (told.slot >= 0) {
    frame.image = options_.frames->image(told.slot);
  } else {
    const auto* pixels = reinterpret_cast<const std::uint8_t*>(pixels_.data());
    frame.image =
        copy_of({pixels, options_.width, options_.height, std::ptrdiff_t{3} * options_.width});
  }
  frame_ = frame;
  return frame;
}

std::optional<AxisMatrix> RemoteWorld::estimate_parameters(const StepPointer& step) {
  return told(step, parameters_bit).parameters;
}

std::optional<Measurement> RemoteWorld::measure(const StepPointer& step) {
  return told(step, measure_bit).measurement;
}

Estimate RemoteWorld::estimate_state(const StepPointer& step) {
  return told(step, estimate_bit).estimate.value();
}

const StepMessage& RemoteWorld::told(const StepPointer& step, StageBit stage) {
  if (message_.done & stage) return message_;
  if (!ask(to_bytes(answer(*step, before(stage))))) {
    throw std::runtime_error("the grader has ended the run");
  }
  if (message_.k != step->k || !(message_.done & stage)) {
    throw std::runtime_error("the grader has told of another stage than the next");
  }
  return message_;
}

void RemoteWorld::end_step(const Step& step) {
  if (message_.k != step.k) return;
  if (options_.frames && message_.frame && message_.frame->slot >= 0) {
    next_slot_ = static_cast<std::uint32_t>(options_.frames->free_beside(message_.frame->slot));
  }
  answer_ = to_bytes(answer(step, parameters_bit | measure_bit | estimate_bit | control_bit));
}

StepMessage RemoteWorld::answer(const Step& step, std::uint32_t done) const {
  StepMessage answer;
  answer.k = step.k;
  answer.next_slot = next_slot_;
  answer.t = step.t;
  answer.done = done & options_.stages;
  if (options_.stages & parameters_bit) {
    answer.parameters = step.parameters;
    AxisMatrix errors;
    if (step.estimator && step.estimator->has_standard_errors() &&
        step.estimator->write_standard_errors_unscaled(errors.data())) {
      answer.standard_errors_unscaled = errors;
    }
  }
  if (options_.stages & measure_bit) {
    answer.measurement = step.measurement;
    if (!step.measurement && step.detection) answer.missed = step.detection->result;
    if (step.blobs && step.frame) answer.blobs = recorded_blobs(*step.blobs);
  }
  if (options_.stages & estimate_bit) answer.estimate = step.estimate;
  if (options_.stages & control_bit) answer.u = step.u;
  return answer;
}

}  // namespace robsim
