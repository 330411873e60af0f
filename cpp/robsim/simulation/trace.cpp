#include "robsim/simulation/trace.hpp"

#include <algorithm>
#include <iterator>

#include "robsim/simulation/trace_columns.hpp"

namespace robsim {

namespace {

constexpr std::int64_t fewest_rows = 64;

Trace::Memory make_memory(std::int64_t rows, std::size_t width, double missing) {
  return std::make_shared<std::vector<double>>(static_cast<std::size_t>(rows) * width, missing);
}

}  // namespace

Trace::Column& Trace::column(const std::string& name, std::size_t width, double missing) {
  const auto found = std::find_if(columns_.begin(), columns_.end(),
                                  [&](const Column& c) { return c.name() == name; });
  if (found != columns_.end() && found->is_listed_) return *found;
  const std::lock_guard<std::mutex> lock(mutex_);
  // What may throw comes first: a column without memory would be found, and written to, later.
  if (found != columns_.end()) {
    if (found->width_ != width) {
      found->memory_ = make_memory(capacity_, width, missing);
      found->width_ = width;
    }
    found->is_listed_ = true;
    return *found;
  }
  Column made(name, width, missing);
  made.memory_ = make_memory(capacity_, width, missing);
  columns_.push_back(std::move(made));
  return columns_.back();
}

Trace::Column& Trace::column(const std::string& name) {
  const TraceGroup& group = trace_group(name);
  return column(name, group.width(), group.missing);
}

Trace::Snapshot Trace::snapshot() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  Snapshot snapshot{rows(), {}};
  std::copy_if(columns_.begin(), columns_.end(), std::back_inserter(snapshot.columns),
               [](const Column& column) { return column.is_listed_; });
  return snapshot;
}

void Trace::reserve(std::int64_t rows) {
  if (rows <= capacity_) return;
  rows = std::max({rows, 2 * capacity_, fewest_rows});  // doubles: single steps stay cheap
  const std::lock_guard<std::mutex> lock(mutex_);
  for (Column& column : columns_) {
    Memory larger = make_memory(rows, column.width_, column.missing_);
    const auto used =
        static_cast<std::ptrdiff_t>(this->rows()) * static_cast<std::ptrdiff_t>(column.width_);
    std::copy_n(column.memory_->begin(), used, larger->begin());
    column.memory_ = std::move(larger);
  }
  capacity_ = rows;
}

double* Trace::writable(Column& column) {
  if (rows() == capacity_) reserve(capacity_ + 1);
  return column.memory_->data() + static_cast<std::size_t>(rows()) * column.width_;
}

void Trace::append() {
  if (rows() == capacity_) reserve(capacity_ + 1);
  rows_.store(rows() + 1, std::memory_order_release);
}

void Trace::clear() {
  const std::lock_guard<std::mutex> lock(mutex_);
  for (Column& column : columns_) {
    if (column.memory_.use_count() > 1) {
      column.memory_ = make_memory(capacity_, column.width_, column.missing_);
    }
  }
  for (Column& column : columns_) {
    column.is_listed_ = false;
    std::fill(column.memory_->begin(), column.memory_->end(), column.missing_);
  }
  rows_.store(0, std::memory_order_release);
}

}  // namespace robsim
