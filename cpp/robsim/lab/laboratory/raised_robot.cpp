#include "robsim/lab/laboratory/raised_robot.hpp"

#include <cstring>
#include <utility>

namespace robsim {

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

}  // namespace robsim
