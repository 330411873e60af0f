#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

namespace robsim {

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
