#include "robsim/simulation/sights.hpp"

#include <tuple>

namespace robsim {

namespace {

constexpr std::size_t most_bytes = std::size_t{128} << 20;

auto seen(const Truth& truth) {
  return std::make_tuple(truth.pose.x, truth.pose.y, truth.pose.heading, truth.hidden, truth.view.x,
                         truth.view.y, truth.noise);
}

std::size_t bytes_of(const Image& image) { return std::size_t{3} * image.width() * image.height(); }

}  // namespace

std::shared_ptr<const Sight> Sights::at(const Truth& truth) const {
  const auto found = by_step_.find(truth.k);
  if (found == by_step_.end() || seen(found->second.first) != seen(truth)) return nullptr;
  return found->second.second;
}

void Sights::keep(const Truth& truth, const Step& step) {
  if (!step.frame || by_step_.count(truth.k)) return;
  const std::size_t bytes = bytes_of(step.frame->image);
  if (bytes_ + bytes > most_bytes) return;
  bytes_ += bytes;
  by_step_[truth.k] = {truth,
                       std::make_shared<Sight>(Sight{*step.frame, step.blobs, step.detection})};
}

}  // namespace robsim
