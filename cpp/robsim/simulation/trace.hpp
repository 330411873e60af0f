#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace robsim {

/// The recorded run: named columns of `width` numbers a step, NaN where nothing was recorded.
/// Rows that are written once do not change: a column that outgrows its memory moves to a new one,
/// so that a snapshot may be read while another thread goes on recording.
class Trace {
 public:
  using Memory = std::shared_ptr<std::vector<double>>;

  class Column {
   public:
    Column(std::string name, std::size_t width, double missing)
        : name_(std::move(name)), width_(width), missing_(missing) {}

    const std::string& name() const { return name_; }
    std::size_t width() const { return width_; }
    const Memory& memory() const { return memory_; }

   private:
    friend class Trace;
    std::string name_;
    std::size_t width_;
    double missing_;  // stands where nothing is written
    Memory memory_;
    bool is_listed_ = true;  // false after clear(), until it is asked for again
  };

  /// The column of this name, made with this width if there is none yet. The reference stays good.
  Column& column(const std::string& name, std::size_t width, double missing = nan);

  /// The same for a group of the schema, with its width.
  Column& column(const std::string& name);

  /// The columns with the memory they have now, and the rows in it.
  struct Snapshot {
    std::int64_t rows;
    std::vector<Column> columns;
  };
  Snapshot snapshot() const;

  std::int64_t rows() const { return rows_.load(std::memory_order_acquire); }

  /// Makes room for so many rows in all, so that appending them allocates nothing.
  void reserve(std::int64_t rows);

  /// The numbers of the row that is being written, all missing at first.
  double* writable(Column& column) {
    if (rows() == capacity_) reserve(capacity_ + 1);
    return column.memory_->data() + static_cast<std::size_t>(rows()) * column.width_;
  }

  /// Ends the row that is being written.
  void append() {
    if (rows() == capacity_) reserve(capacity_ + 1);
    rows_.store(rows() + 1, std::memory_order_release);
  }

  /// Forgets all rows and columns, keeps the memory that nobody else holds for the next run.
  void clear();

 private:
  static constexpr double nan = std::numeric_limits<double>::quiet_NaN();

  mutable std::mutex mutex_;  // of the list of columns and of where their memory is
  std::deque<Column> columns_;
  std::int64_t capacity_ = 0;
  std::atomic<std::int64_t> rows_{0};
};

/// A single column of a trace: a number a step.
struct TraceField {
  std::string name;
  std::string unit;  // "" = a plain number
};

/// Columns that are recorded together, in a row of as many numbers as there are fields.
struct TraceGroup {
  std::string name;
  std::vector<std::size_t> shape;  // of the numbers of a step; their product is the width
  std::vector<TraceField> fields;
  std::string description;
  bool is_flag = false;                                       // a number above 0 stands for true
  double missing = std::numeric_limits<double>::quiet_NaN();  // stands where it was not recorded
  // Whether the trace of a simulated run, or of frames from elsewhere, must have it.
  bool in_simulated = false;
  bool in_recorded = false;

  std::size_t width() const { return fields.size(); }
};

/// All groups of fixed columns. To these come `state`, as wide as the state estimator makes it, and
/// `blobs_<color>`.
const std::vector<TraceGroup>& trace_schema();

/// The group of this name. Throws std::invalid_argument if there is none.
const TraceGroup& trace_group(const std::string& name);

}  // namespace robsim
