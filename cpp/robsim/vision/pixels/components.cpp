#include "robsim/vision/pixels/components.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace robsim::pixels {

namespace {

// The lower border of a component that is complete: below all rows.
constexpr int complete = std::numeric_limits<int>::max();

// A row of so many runs is noise, of which a fourth is isolated pixels: they are dropped before
// they become components, since the smallest ones are dropped anyway.
constexpr std::size_t noisy_row = 16;

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
  is_held_ = false;
  runs_.count = 0;
  open_.clear();
  free_.clear();
  joined_.clear();
  complete_.clear();
}

void ComponentFinder::add_row(const BitRow& row, int width) {
  const bool was_held = is_held_;
  if (is_held_) add_held(row);
  is_held_ = minimum_area_ > 1 && runs_.count >= noisy_row;
  if (!is_held_) {
    add_now(row, width);
    return;
  }
  if (!was_held) set_all(above_held_, width);  // none is isolated then
  held_ = row;
  held_width_ = width;
}

const std::vector<Component>& ComponentFinder::finish() {
  if (is_held_) add_held(BitRow(held_.size()));
  is_held_ = false;
  add_now({}, 0);
  return complete_;
}

// Adds the row above this one, without its isolated pixels.
void ComponentFinder::add_held(const BitRow& below) {
  drop_isolated(above_held_, held_, below, remaining_);
  add_now(remaining_, held_width_);
  std::swap(above_held_, held_);
}

void ComponentFinder::add_now(const BitRow& row, int width) {
  std::swap(above_, runs_);
  find_runs(row, width);
  if (above_.count + runs_.count > 0) {
    find_contacts();
    join_contacts();
    close_row();
  }
  ++v_;
}

// Each run is a component of its own at first.
void ComponentFinder::find_runs(const BitRow& row, int width) {
  runs_.count = 0;
  runs_.reserve((static_cast<std::size_t>(width) + 1) / 2);
  Run* run = runs_.all.data();
  for_each_run(row, width, [&](int left, int right) { *run++ = {left, right, 0}; });
  runs_.count = static_cast<std::size_t>(run - runs_.all.data());
  while (free_.size() < runs_.count) {
    free_.push_back(static_cast<std::uint32_t>(open_.size()));
    open_.emplace_back();
  }
  const std::size_t left_free = free_.size() - runs_.count;
  for (std::size_t i = 0; i < runs_.count; ++i) {
    const std::uint32_t slot = free_[left_free + i];
    Run& it = runs_.all[i];
    it.slot = slot;
    open_[slot] = {of_run(it.left, it.right, v_), slot};
  }
  free_.resize(left_free);
}

// Goes along both rows at once, past the run that ends first.
void ComponentFinder::find_contacts() {
  contacts_.reserve(above_.count + runs_.count);
  std::size_t found = 0, i = 0, j = 0;
  while (i < above_.count && j < runs_.count) {
    const Run& above = above_.all[i];
    const Run& below = runs_.all[j];
    contacts_.all[found] = {above.slot, below.slot};
    // They overlap, or touch at a corner.
    found += static_cast<std::size_t>(above.left <= below.right) &
             static_cast<std::size_t>(below.left <= above.right);
    const bool ends_first = above.right < below.right;
    i += static_cast<std::size_t>(ends_first);
    j += static_cast<std::size_t>(!ends_first);
  }
  contacts_.count = found;
}

void ComponentFinder::join_contacts() {
  for (std::size_t i = 0; i < contacts_.count; ++i) {
    const Contact& contact = contacts_.all[i];
    const std::uint32_t above = root_of(contact.above);
    const std::uint32_t below = root_of(contact.below);
    if (above == below) continue;
    // A new run is joined to what is above it, and that is what more of above is joined to.
    const bool is_new = below == contact.below;
    const std::uint32_t root = is_new ? above : below;
    const std::uint32_t joined = is_new ? below : above;
    add(open_[root].component, open_[joined].component);
    open_[joined].parent = root;
    joined_.push_back(joined);
  }
}

// Without a branch for whether a slot is a root or, as most of the others, joined to one.
std::uint32_t ComponentFinder::root_of(std::uint32_t i) {
  std::uint32_t parent = open_[i].parent;
  for (std::uint32_t next = open_[parent].parent; next != parent; next = open_[parent].parent) {
    open_[i].parent = next;
    i = parent;
    parent = next;
  }
  return parent;
}

// Takes what this row does not touch for complete, and gives slots back.
void ComponentFinder::close_row() {
  for (std::size_t i = 0; i < runs_.count; ++i) runs_.all[i].slot = root_of(runs_.all[i].slot);
  std::size_t free = free_.size();
  free_.resize(free + above_.count);
  for (std::size_t i = 0; i < above_.count; ++i) {
    const std::uint32_t root = root_of(above_.all[i].slot);
    Component& component = open_[root].component;
    const bool is_complete = component.box.bottom <= v_;
    if (is_complete & (component.area >= minimum_area_)) complete_.push_back(component);
    component.box.bottom = std::max(component.box.bottom, static_cast<int>(is_complete) * complete);
    free_[free] = root;
    free += static_cast<std::size_t>(is_complete);
  }
  free_.resize(free);
  free_.insert(free_.end(), joined_.begin(), joined_.end());
  joined_.clear();
}

}  // namespace robsim::pixels
