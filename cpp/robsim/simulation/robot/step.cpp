#include "robsim/simulation/robot/step.hpp"

#include <stdexcept>
#include <string>
#include <utility>

#include "robsim/simulation/seam/thread_guard.hpp"

namespace robsim {

namespace {

constexpr const char* no_frames =
    "the frames are not given: use step.measurement or what else there is";

std::int64_t pixels_of(const Frame& frame) {
  return std::int64_t{frame.image.width()} * frame.image.height();
}

}  // namespace

const Frame* Step::look() {
  const auto alone = is_over ? std::nullopt : std::optional<RunGuard::Look>(std::in_place, *guard);
  if (!has_frame) return nullptr;
  if (!frame) frame = known ? known->frame : open_camera("frame").frame();
  return &*frame;
}

const BlobsByColor& Step::find_blobs() {
  const auto alone = is_over ? std::nullopt : std::optional<RunGuard::Look>(std::in_place, *guard);
  if (blobs) return *blobs;
  if (has_frame) {
    open_camera("blobs");
    MarkerVision& finder = open_vision();
    const Frame& seen = *look();
    const NativeWork native(pixels_of(seen));
    blobs = known && known->blobs ? known->blobs : finder.find(seen);
  } else {
    blobs.emplace();
    if (!vision) return *blobs;
    for (const ColorClass& color : vision->colors()) (*blobs)[color.name];
  }
  return *blobs;
}

const Frame* Step::given_frame() {
  if (has_frame && given == Given::blobs) {
    throw std::runtime_error("the frames are not given, but the blobs in them are: use step.blobs");
  }
  if (has_frame && given == Given::pose) throw std::runtime_error(no_frames);
  return look();
}

const BlobsByColor& Step::given_blobs() {
  if (has_frame && given == Given::pose) throw std::runtime_error(no_frames);
  return find_blobs();
}

const std::optional<Sample>& Step::find_sample() {
  if (!sample_ && moves) {
    const auto& [pose, pose_1, pose_2, u, of_step, turn] = *moves;
    sample_.emplace(Sample{regression(pose, pose_1, pose_2, u, turn), of_step});
  }
  return sample_;
}

std::optional<Measurement> Step::detect() {
  const MarkerVision& by = open_vision();
  const Frame& seen = *look();
  const NativeWork native(pixels_of(seen));
  const BlobsByColor& found = find_blobs();
  if (known) detection = known->detection;
  if (!detection) {
    detection = robsim::detect(found, by.markers(), seen, by.colors(), by.smoothing());
  }
  return detection->measurement;
}

Camera& Step::open_camera(const char* what) const {
  if (camera) return *camera;
  throw std::runtime_error("the " + std::string(what) + " of step " + std::to_string(k) +
                           " was not kept: ask for step." + what + " during the step");
}

MarkerVision& Step::open_vision() const {
  if (vision) return *vision;
  throw std::runtime_error("this step has no markers: it was made without markers=...");
}

const MarkerLayout& Step::markers() const { return open_vision().markers(); }

const std::vector<ColorClass>& Step::colors() const { return open_vision().colors(); }

void Step::check_thread() const {
  if (!is_over) guard->check_thread();
}

void Step::begin(const std::shared_ptr<Camera>& the_camera) {
  sample_.reset();
  moves.reset();
  measurement.reset();
  detection.reset();
  estimate.reset();
  u.reset();
  frame.reset();
  blobs.reset();
  known.reset();
  if (camera != the_camera) camera = the_camera;  // counting references costs time
}

void Step::end() {
  camera.reset();
  known.reset();
  is_over = true;
}

}  // namespace robsim
