#include "robsim/lab/laboratory/laboratory_camera.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <utility>

#include "robsim/base/system.hpp"

namespace robsim {

namespace {

// The third component of what a homography makes of a pixel: its sign changes at the horizon.
double depth(const PlaneMap& map, const Point& pixel) {
  const PlaneMap::Matrix& m = map.matrix();
  const Point ideal = map.ideal(pixel);
  return m[6] * ideal.x + m[7] * ideal.y + m[8];
}

}  // namespace

Warp view_warp(const Scene& scene, int width, int height, const PlaneMap& plane_map) {
  constexpr double nowhere = std::numeric_limits<double>::quiet_NaN();
  const bool is_seen_in_front = depth(plane_map, {(width - 1) / 2.0, (height - 1) / 2.0}) > 0;
  return Warp(width, height, scene.width(), scene.height(), [&](const Point& pixel) -> Point {
    if ((depth(plane_map, pixel) > 0) != is_seen_in_front) return {nowhere, nowhere};
    return scene.camera().to_pixel(plane_map.to_world(pixel));
  });
}

RaisedRobot::RaisedRobot(std::shared_ptr<const Scene> scene, std::shared_ptr<const Warp> warp)
    : scene_(std::move(scene)),
      warp_(std::move(warp)),
      black_{Image(scene_->width(), scene_->height()), 0},
      white_{Image(scene_->width(), scene_->height()), 255} {
  for (Cutout* cutout : {&black_, &white_}) cutout->fill(cutout->image.box());
}

void RaisedRobot::Cutout::fill(const PixelBox& box) {
  if (box.empty()) return;
  const WritableView view = image.writable_view();
  for (int v = box.top; v < box.bottom; ++v) {
    std::memset(view.row(v) + std::ptrdiff_t{3} * box.left, color,
                std::size_t{3} * static_cast<std::size_t>(box.right - box.left));
  }
}

void RaisedRobot::draw(const Pose& pose, const WritableView& frame) {
  PixelBox box;
  for (Cutout* cutout : {&black_, &white_}) {
    box = scene_->draw_robot(pose, {}, cutout->image.writable_view());
  }
  if (box.empty()) return;
  warp_->lay_over(black_.image.view(), white_.image.view(), box, frame);
  for (Cutout* cutout : {&black_, &white_}) cutout->fill(box);
}

namespace {

constexpr double patience = 0.1;  // s without a frame: then whoever asks may look at other things

std::size_t row_size(const WritableView& view) {
  return std::size_t{3} * static_cast<std::size_t>(view.width);
}

void copy_rows(const ImageView& from, int first, int end, const WritableView& to) {
  for (int v = first; v < end; ++v) std::memcpy(to.row(v), from.row(v), row_size(to));
}

void brighten(const WritableView& image, double factor) {
  std::array<std::uint8_t, 256> bright;
  for (std::size_t value = 0; value < bright.size(); ++value) {
    bright[value] = static_cast<std::uint8_t>(
        std::clamp(std::lround(factor * static_cast<double>(value)), 0L, 255L));
  }
  for (int v = 0; v < image.height; ++v) {
    std::uint8_t* const row = image.row(v);
    std::transform(row, row + row_size(image), row, [&](std::uint8_t x) { return bright[x]; });
  }
}

}  // namespace

LaboratoryCamera::LaboratoryCamera(std::shared_ptr<Laboratory> laboratory,
                                   std::shared_ptr<const Scene> scene,
                                   const LaboratoryCameraOptions& options)
    : laboratory_(std::move(laboratory)), options_(options), renderer_(std::move(scene)) {
  if (options_.top) raised_.emplace(renderer_.scene(), options_.top);
}

void LaboratoryCamera::open() {
  if (is_open_) return;
  const double now = monotonic_now();
  try {
    laboratory_->start();
  } catch (const std::runtime_error& error) {
    throw CaptureError(CaptureFault::failed, error.what());
  }
  if (laboratory_->is_unplugged() || options_.faults.unplugged.has(now - laboratory_->time_of(0))) {
    throw CaptureError(CaptureFault::no_camera, "the simulated camera is unplugged: plug it in");
  }
  if (!laboratory_->take_camera()) {
    throw CaptureError(CaptureFault::busy,
                       "somebody else has the simulated camera: close theirs first");
  }
  is_open_ = true;
  is_interrupted_ = false;
  next_ = laboratory_->first_tick_from(now);
  last_due_ = 0;
  last_ = {};
}

void LaboratoryCamera::close() noexcept {
  if (is_open_) laboratory_->give_camera_back();
  is_open_ = false;
  last_ = {};
}

void LaboratoryCamera::interrupt() noexcept {
  is_interrupted_ = true;
  laboratory_->wake();
}

std::optional<Captured> LaboratoryCamera::next(ImagePool& pool) {
  const double deadline = monotonic_now() + patience;
  while (true) {
    const std::int64_t k = next_;
    const double exposed = laboratory_->time_of(k);
    const double due =
        std::max(last_due_, exposed + options_.delay + options_.faults.lateness_of(k));
    const bool has_come = wait_for(k, due, deadline);
    if (laboratory_->is_unplugged() ||
        (has_come && options_.faults.unplugged.has(since_start(k)))) {
      throw CaptureError(CaptureFault::unplugged, "the simulated camera has been unplugged");
    }
    if (!has_come) return std::nullopt;
    ++next_;
    last_due_ = due;
    if (!is_lost(k, due)) return captured(k, pool);
  }
}

bool LaboratoryCamera::wait_for(std::int64_t k, double due, double deadline) {
  try {
    if (laboratory_->wait_for(k, due, deadline, is_interrupted_)) return true;
  } catch (const std::runtime_error& error) {
    throw CaptureError(CaptureFault::failed, error.what());
  }
  is_interrupted_ = false;
  return false;
}

// True if nobody gets the frame of a tick.
bool LaboratoryCamera::is_lost(std::int64_t k, double due) const {
  const double exposed = laboratory_->time_of(k);
  if (options_.faults.drops(k) || laboratory_->is_stalled_at(exposed) ||
      options_.faults.stall.has(since_start(k))) {
    return true;
  }
  const bool is_behind = monotonic_now() > due + laboratory_->dt();
  if (is_behind) laboratory_->count_skipped();
  return is_behind;
}

Captured LaboratoryCamera::captured(std::int64_t k, ImagePool& pool) {
  Captured frame;
  frame.exposed = laboratory_->time_of(k);
  frame.device_time = since_start(k);
  frame.is_complete = !options_.faults.tears(k);
  if (!frame.is_complete) {
    frame.image = torn(picture(k, pool), k, pool);
  } else {
    if (last_.empty() || !options_.faults.repeats(k)) {
      last_ = picture(k, pool);
      last_shown_ = k;
    }
    frame.image = last_;
    laboratory_->set_shown(k, last_shown_);
  }
  frame.arrived = monotonic_now();
  return frame;
}

Image LaboratoryCamera::picture(std::int64_t k, ImagePool& pool) {
  const Laboratory::Tick tick = laboratory_->tick(k);
  const bool is_drawn = !tick.hidden && !raised_;
  const Image drawn = renderer_.render(is_drawn ? std::optional(tick.pose) : std::nullopt);
  const double exposure = options_.faults.exposure_at(since_start(k));
  if (!options_.warp && exposure == 1 && options_.noise.is_off()) return drawn;
  const bool is_warped = options_.warp != nullptr;
  Image image = is_warped ? pool.take(options_.warp->width(), options_.warp->height())
                          : pool.take(drawn.width(), drawn.height());
  const WritableView pixels = image.writable_view();
  if (raised_) {
    draw_raised(drawn, tick, pixels);
  } else if (is_warped) {
    options_.warp->apply(drawn.view(), pixels);
  } else {
    copy_rows(drawn.view(), 0, drawn.height(), pixels);
  }
  if (exposure != 1) brighten(pixels, exposure);
  if (!options_.noise.is_off()) {
    options_.noise.add(image.view(), options_.noise_seed, static_cast<std::uint64_t>(k), pixels);
  }
  return image;
}

void LaboratoryCamera::draw_raised(const Image& scene, const Laboratory::Tick& tick,
                                   const WritableView& frame) {
  if (floor_.empty()) {
    floor_ = Image(frame.width, frame.height);
    options_.warp->apply(scene.view(), floor_.writable_view());
  }
  copy_rows(floor_.view(), 0, frame.height, frame);
  if (!tick.hidden) raised_->draw(tick.pose, frame);
}

// The upper part of a picture; below it that of the one before, or nothing.
Image LaboratoryCamera::torn(const Image& whole, std::int64_t k, ImagePool& pool) const {
  Image image = pool.take(whole.width(), whole.height());
  const WritableView pixels = image.writable_view();
  const int row = options_.faults.torn_row(k, whole.height());
  copy_rows(whole.view(), 0, row, pixels);
  if (!last_.empty() && options_.faults.tears_into_the_last(k)) {
    copy_rows(last_.view(), row, whole.height(), pixels);
  } else {
    for (int v = row; v < whole.height(); ++v) std::memset(pixels.row(v), 0, row_size(pixels));
  }
  return image;
}

}  // namespace robsim
