#include "robsim/simulation/robot/step.hpp"

#include <stdexcept>
#include <string>
#include <utility>

#include "robsim/simulation/seam/thread_guard.hpp"
#include "robsim/vision/explain_detection.hpp"
#include "robsim/vision/second_look.hpp"

namespace robsim {

namespace {

BlobOptions with_smoothing(BlobOptions options, std::optional<int> smoothing) {
  if (smoothing) options.smoothing = *smoothing;
  return options;
}

std::int64_t pixels_in(const PixelBox& box) {
  return (std::int64_t{box.right} - box.left) * (std::int64_t{box.bottom} - box.top);
}

// What a measurement is refined by, at most.
std::int64_t pixels_of(const Detection& found) {
  return found.measurement ? pixels_in(found.first->box) + pixels_in(found.second->box) : 0;
}

}  // namespace

MarkerVision::MarkerVision(std::vector<ColorClass> colors, const MarkerLayout& markers,
                           std::optional<int> smoothing)
    : markers_(markers),
      smoothing_(smoothing),
      finder_(std::move(colors), with_smoothing({}, smoothing)) {}

BlobsByColor MarkerVision::find(const Frame& frame) {
  const NativeWork native(std::int64_t{frame.image.width()} * frame.image.height());
  const BlobOptions options =
      with_smoothing(marker_blobs(markers_, frame.plane_map, frame.image.view()), smoothing_);
  if (!(options == finder_.options())) finder_ = BlobFinder(finder_.colors(), options);
  return finder_.find(frame.image.view());
}

Detection MarkerVision::detect(const BlobsByColor& blobs, const Frame& frame) const {
  Detection detection = robsim::detect(blobs, markers_, frame.plane_map);
  if (!detection.measurement) {
    const NativeWork native(std::int64_t{frame.image.width()} * frame.image.height());
    look_again(detection, frame.image.view(), colors(), frame.plane_map, smoothing_);
  }
  const NativeWork native(pixels_of(detection));
  refine(detection, frame.image.view(), frame.plane_map, frame.headings);
  examine_frame(detection, frame.image.view(), frame.plane_map);
  return detection;
}

namespace {

constexpr const char* no_frames =
    "the frames are not given: use step.measurement or what else there is";

}  // namespace

const Frame* Step::look() {
  const auto alone = is_over ? std::nullopt : std::optional<RunGuard::Look>(std::in_place, *guard);
  if (!has_frame) return nullptr;
  if (!frame) frame = open_camera("frame").frame();
  return &*frame;
}

const BlobsByColor& Step::find_blobs() {
  const auto alone = is_over ? std::nullopt : std::optional<RunGuard::Look>(std::in_place, *guard);
  if (blobs) return *blobs;
  if (has_frame) {
    open_camera("blobs");
    blobs = open_vision().find(*look());
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
    sample_.emplace(Sample{
        turn ? regression(pose, pose_1, pose_2, u, *turn) : regression(pose, pose_1, pose_2, u),
        of_step});
  }
  return sample_;
}

std::optional<Measurement> Step::detect() {
  const BlobsByColor& found = find_blobs();
  detection = open_vision().detect(found, *frame);
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
  if (camera != the_camera) camera = the_camera;  // counting references costs time
}

void Step::end() {
  camera.reset();
  is_over = true;
}

}  // namespace robsim
