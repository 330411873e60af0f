#include "robsim/vision/pixels/components.hpp"

#include <algorithm>
#include <utility>

namespace robsim::pixels {

namespace {

constexpr std::uint32_t none = 0xFFFFFFFF;

void add(Component& sum, const Component& part) {
  sum.area += part.area;
  sum.sum_u += part.sum_u;
  sum.sum_v += part.sum_v;
  sum.box = {std::min(sum.box.left, part.box.left), std::min(sum.box.top, part.box.top),
             std::max(sum.box.right, part.box.right), std::max(sum.box.bottom, part.box.bottom)};
}

Component of_run(int left, int right, int v) {
  const std::int64_t length = right - left;
  // sum of u over the run = length (left + right - 1)/2
  return {length, length * (left + right - 1) / 2, length * v, {left, v, right, v + 1}};
}

}  // namespace

void ComponentFinder::begin(std::int64_t minimum_area) {
  minimum_area_ = minimum_area;
  v_ = 0;
  runs_.clear();
  open_.clear();
  complete_.clear();
}

void ComponentFinder::add_row(const BitRow& row, int width) {
  std::swap(above_, runs_);
  runs_.clear();
  std::size_t first_above = 0;
  for_each_run(row, width, [&](int left, int right) { add_run(left, right, first_above); });
  close_row();
  ++v_;
}

const std::vector<Component>& ComponentFinder::finish() {
  runs_.clear();
  close_row();
  return complete_;
}

void ComponentFinder::add_run(int left, int right, std::size_t& first_above) {
  // Runs are neighbours if they overlap or touch at a corner.
  while (first_above < above_.size() && above_[first_above].right < left) ++first_above;
  std::size_t i = first_above;
  const auto is_neighbour = [&] { return i < above_.size() && above_[i].left <= right; };
  const Component run = of_run(left, right, v_);
  if (!is_neighbour()) {
    const auto slot = static_cast<std::uint32_t>(open_.size());
    open_.push_back({run, slot});
    runs_.push_back({left, right, slot});
    return;
  }
  const std::uint32_t component = root_of(above_[i].component);
  add(open_[component].component, run);
  for (++i; is_neighbour(); ++i) join(component, root_of(above_[i].component));
  runs_.push_back({left, right, component});
}

std::uint32_t ComponentFinder::root_of(std::uint32_t i) {
  while (open_[i].parent != i) {
    open_[i].parent = open_[open_[i].parent].parent;
    i = open_[i].parent;
  }
  return i;
}

void ComponentFinder::join(std::uint32_t a, std::uint32_t b) {
  if (a == b) return;
  add(open_[a].component, open_[b].component);
  open_[b].parent = a;
}

void ComponentFinder::close_row() {
  if (open_.empty()) return;  // no run in this row, none in the row above
  new_slot_.assign(open_.size(), none);
  next_open_.clear();
  for (Run& run : runs_) {
    const std::uint32_t root = root_of(run.component);
    if (new_slot_[root] == none) {
      new_slot_[root] = static_cast<std::uint32_t>(next_open_.size());
      next_open_.push_back({open_[root].component, new_slot_[root]});
    }
    run.component = new_slot_[root];
  }
  for (std::uint32_t i = 0; i < open_.size(); ++i) {
    const auto& [component, parent] = open_[i];
    const bool is_complete = parent == i && new_slot_[i] == none;
    if (is_complete && component.area >= minimum_area_) complete_.push_back(component);
  }
  std::swap(open_, next_open_);
}

}  // namespace robsim::pixels
