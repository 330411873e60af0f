#include "robsim/simulation/robot/marker_vision.hpp"

#include <utility>

#include "robsim/simulation/seam/native_work.hpp"
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

}  // namespace robsim
