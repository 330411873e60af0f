#include "robsim/simulation/trace.hpp"

#include <algorithm>
#include <iterator>
#include <stdexcept>
#include <utility>

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

namespace {

using std::string_literals::operator""s;

using Fields = std::vector<TraceField>;

const Fields pose_fields = {{"x", "px"}, {"y", "px"}, {"heading", "rad"}};

Fields poses(const std::string& suffix) {
  Fields fields = pose_fields;
  for (TraceField& field : fields) field.name += "_" + suffix;
  return fields;
}

Fields covariances(const std::string& prefix) {
  Fields fields;
  for (const TraceField& row : pose_fields) {
    for (const TraceField& column : pose_fields) {
      fields.push_back({prefix + row.name + "_" + column.name, row.unit + " " + column.unit});
    }
  }
  return fields;
}

// The 15 parameters of the robot model, row by row of theta. The model is that of a pose: a1 and a2
// are plain numbers, b1 and b2 are for 1 V, d1 is a length or an angle.
Fields model_parameters() {
  Fields fields;
  for (const auto& [axis, unit] : {std::pair{"X", "px"}, {"Y", "px"}, {"P", "rad"}}) {
    for (const std::string name : {"a1", "a2"}) fields.push_back({name + axis, ""});
    for (const std::string name : {"b1", "b2"}) fields.push_back({name + axis, unit + "/V"s});
    fields.push_back({"d1"s + axis, unit});
  }
  return fields;
}

// Their standard errors, divided by those of the equation noise.
Fields standard_errors_unscaled() {
  Fields fields = model_parameters();
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const std::string noise = i < 10 ? "px" : "rad";
    const std::string& unit = fields[i].unit;
    fields[i] = {"standard_error_unscaled_" + fields[i].name, unit.empty()    ? "1/" + noise
                                                              : unit == noise ? ""
                                                                              : "1/V"};
  }
  return fields;
}

TraceGroup group(std::string name, std::vector<std::size_t> shape, Fields fields,
                 std::string description) {
  TraceGroup group;
  group.name = std::move(name);
  group.shape = std::move(shape);
  group.fields = std::move(fields);
  group.description = std::move(description);
  return group;
}

TraceGroup flag(const std::string& name, std::string description) {
  TraceGroup flag = group(name, {}, {{name, ""}}, std::move(description));
  flag.is_flag = true;
  flag.missing = 0;
  return flag;
}

TraceGroup simulated(TraceGroup group) {
  group.in_simulated = true;
  return group;
}

TraceGroup recorded(TraceGroup group) {
  group.in_recorded = true;
  return group;
}

TraceGroup zero_where_missing(TraceGroup group) {
  group.missing = 0;
  return group;
}

std::vector<TraceGroup> make_schema() {
  return {
      group("t", {}, {{"t", "s"}}, "Time (N,) (s): the time of the frames, if they have one."),
      simulated(group("pose_true", {3}, poses("true"),
                      "True pose (N, 3): x, y (work-area px), heading (rad).")),
      simulated(group("u", {2}, {{"u1", "V"}, {"u2", "V"}},
                      "Input of the step (N, 2): left and right voltage (V).")),
      simulated(flag("bounced", "The robot bounced off a wall in this step (N,).")),
      recorded(group("pose_measured", {3}, poses("measured"),
                     "Measured pose (N, 3), NaN where the robot was not seen.")),
      group("pose_held", {3}, poses("held"),
            "Last measured pose (N, 3), NaN before the first measured pose and without a "
            "measurement."),
      group("pose_estimated", {3}, poses("estimated"),
            "Estimated pose (N, 3), NaN without a state estimator."),
      group("covariance_measured", {3, 3}, covariances("cov_measured_"),
            "Covariance of the measured pose (N, 3, 3), NaN where it is not known."),
      group("misfit", {}, {{"misfit", ""}},
            "Misfit of the measurement (N,), by which its variance is multiplied; 1 = the "
            "residuals of the fit are only noise."),
      group("signal_to_noise", {}, {{"signal_to_noise", ""}},
            "Signal-to-noise ratio of the markers' edges (N,): a pose is reliable from 4 on."),
      zero_where_missing(group("missed", {}, {{"missed", ""}},
                               "Code of the reason why the default measurement did not detect "
                               "the robot (N,); 0 = detected, or no measurement. "
                               "`missed_reasons` gives the reason as text.")),
      group("covariance", {3, 3}, covariances("cov_"),
            "Covariance of the estimated pose (N, 3, 3)."),
      group("parameters", {3, 5}, model_parameters(),
            "Online estimate of the model's parameters (N, 3, 5), NaN without an estimator."),
      group("standard_errors_unscaled", {3, 5}, standard_errors_unscaled(),
            "Standard errors of the parameters (N, 3, 5), for equation noise of standard deviation "
            "1 px, 1 px and 1 rad; NaN if the estimator gives no standard errors."),
      zero_where_missing(group("view", {2}, {{"x_view", "px"}, {"y_view", "px"}},
                               "Position of the camera's view (N, 2): 0 unless the area is "
                               "unlimited (work-area px).")),
      zero_where_missing(group("noise", {2}, {{"noise_gaussian", "%"}, {"noise_uniform", "%"}},
                               "Noise of the camera (N, 2): Gaussian and uniform (%).")),
      group("last_u", {2}, {{"last_u1", "V"}, {"last_u2", "V"}},
            "Input that the robot received since the previous step (N, 2), if the source of the "
            "frames reports it (V); otherwise NaN."),
      flag("hidden", "The robot was hidden from the camera in this step (N,)."),
      flag("interrupted",
           "The robot was stopped after the previous step: the pose does not follow from the "
           "previous input (N,)."),
      flag("unanswered", "The robot had not answered for a second when the input was sent (N,)."),
      group("t_arrival", {}, {{"t_arrival", "s"}},
            "Time at which the frame reached this computer (N,), by the clock of `t` (s)."),
      group("t_sent", {}, {{"t_sent", "s"}},
            "Time at which the input was sent (N,), by the clock of `t` (s)."),
  };
}

}  // namespace

const std::vector<TraceGroup>& trace_schema() {
  static const std::vector<TraceGroup> schema = make_schema();
  return schema;
}

const TraceGroup& trace_group(const std::string& name) {
  const auto& schema = trace_schema();
  const auto found = std::find_if(schema.begin(), schema.end(),
                                  [&](const TraceGroup& group) { return group.name == name; });
  if (found == schema.end()) {
    throw std::invalid_argument("there is no group of columns '" + name + "'");
  }
  return *found;
}

}  // namespace robsim
