#include "robsim/simulation/remote/step_message.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "robsim/base/system.hpp"

namespace robsim {

namespace {

#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "messages are little endian"
#endif

constexpr std::uint32_t most_states = 1024;
constexpr std::uint32_t most_blobs = 512;
constexpr double farthest_place = 1e9;  // px, rad: no robot gets there
constexpr double asymmetry = 1e-6;      // of a covariance, of its largest number: rounding
constexpr auto all_stages = parameters_bit | measure_bit | estimate_bit | control_bit;

// What a message has, as bits.
enum Part : std::uint32_t {
  has_frame_part = 1,
  frame_part = 2,
  sample_part = 4,
  parameters_part = 8,
  errors_part = 16,
  measurement_part = 32,
  covariance_part = 64,
  missed_part = 128,
  estimate_part = 256,
  input_part = 512,
  all_parts = 1023,
};

template <typename Optional>
std::uint32_t bit_if(const Optional& value, Part part) {
  return value ? part : 0U;
}

std::uint32_t parts_of(const StepMessage& m) {
  const bool has_covariance = m.measurement && m.measurement->covariance;
  return bit_if(m.has_frame, has_frame_part) | bit_if(m.frame, frame_part) |
         bit_if(m.sample, sample_part) | bit_if(m.parameters, parameters_part) |
         bit_if(m.standard_errors_unscaled, errors_part) | bit_if(m.measurement, measurement_part) |
         bit_if(has_covariance, covariance_part) | bit_if(m.missed, missed_part) |
         bit_if(m.estimate, estimate_part) | bit_if(m.u, input_part);
}

class Writer {
 public:
  template <typename T>
  Writer& operator<<(const T& value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  Writer& doubles(const double* values, std::size_t count) {
    bytes_.append(reinterpret_cast<const char*>(values), count * sizeof *values);
    return *this;
  }
  Writer& operator<<(const Pose& pose) { return *this << pose.x << pose.y << pose.heading; }
  Writer& operator<<(const Input& u) { return *this << u.u1 << u.u2; }
  Writer& operator<<(const AxisMatrix& matrix) { return doubles(matrix.data(), 15); }
  Writer& operator<<(const PoseCovariance& P) { return doubles(P.data(), 9); }

  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

class Reader {
 public:
  Reader(const char* bytes, std::size_t size) : next_(bytes), end_(bytes + size) {}

  template <typename T>
  T get() {
    T value;
    if (left() < sizeof value) throw MessageError("a message that is too short");
    std::memcpy(&value, next_, sizeof value);
    next_ += sizeof value;
    return value;
  }
  void doubles(double* values, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) values[i] = get<double>();
  }
  Pose pose() {
    Pose pose;
    pose.x = get<double>();
    pose.y = get<double>();
    pose.heading = get<double>();
    return pose;
  }
  Input input() {
    Input u;
    u.u1 = get<double>();
    u.u2 = get<double>();
    return u;
  }
  template <typename Matrix>
  Matrix matrix() {
    Matrix matrix;
    doubles(matrix.data(), static_cast<std::size_t>(matrix.size()));
    return matrix;
  }
  std::size_t left() const { return static_cast<std::size_t>(end_ - next_); }

 private:
  const char* next_;
  const char* end_;
};

void check_finite(const double* values, std::size_t count, const char* what, StageBit stage) {
  const auto is_wild = [](double value) { return !std::isfinite(value); };
  const double* wild = std::find_if(values, values + count, is_wild);
  if (wild == values + count) return;
  throw MessageError(std::string(what) + " must be finite, got " + to_text(*wild), stage);
}

void check(const Pose& pose, const char* what, StageBit stage) {
  const double values[] = {pose.x, pose.y, pose.heading};
  check_finite(values, 3, what, stage);
  for (const double value : values) {
    if (std::abs(value) <= farthest_place) continue;
    throw MessageError(std::string(what) + " must be within " + to_text(farthest_place) + ", got " +
                           to_text(value),
                       stage);
  }
}

void check(const PoseCovariance& P, StageBit stage) {
  check_finite(P.data(), 9, "the covariance", stage);
  if (P.diagonal().minCoeff() < 0) {
    throw MessageError("the covariance must have variances of at least 0 on its diagonal, got " +
                           to_text(P.diagonal().minCoeff()),
                       stage);
  }
  const double difference = (P - P.transpose()).cwiseAbs().maxCoeff();
  if (difference > asymmetry * P.cwiseAbs().maxCoeff()) {
    throw MessageError(
        "the covariance must be symmetric, got two sides that differ by " + to_text(difference),
        stage);
  }
}

// NaN = not known.
void check_figure(double value, const char* what, StageBit stage) {
  if (std::isnan(value) || std::isfinite(value)) return;
  throw MessageError(std::string(what) + " must not be infinite", stage);
}

void check_numbers(const StepMessage& m) {
  if (m.parameters) {
    check_finite(m.parameters->data(), 15, "the parameters", parameters_bit);
  }
  if (m.standard_errors_unscaled) {
    const double* errors = m.standard_errors_unscaled->data();
    for (int i = 0; i < 15; ++i) check_figure(errors[i], "a standard error", parameters_bit);
  }
  if (m.measurement) {
    check(m.measurement->pose, "the measured pose", measure_bit);
    if (m.measurement->covariance) check(*m.measurement->covariance, measure_bit);
    check_figure(m.measurement->misfit, "the misfit", measure_bit);
    check_figure(m.measurement->signal_to_noise, "the signal to noise", measure_bit);
  }
  if (m.estimate) {
    check(m.estimate->pose, "the estimated pose", estimate_bit);
    check(m.estimate->covariance, estimate_bit);
    const std::vector<double>& state = m.estimate->state;
    check_finite(state.data(), state.size(), "the further state", estimate_bit);
  }
  if (m.u) {
    const double u[] = {m.u->u1, m.u->u2};
    check_finite(u, 2, "the input", control_bit);
  }
}

void write_frame(Writer& to, const FrameMessage& frame) {
  to << frame.slot << frame.headings << frame.index << frame.t;
  to.doubles(frame.plane_map.matrix().data(), 9);
}

std::optional<FrameMessage> read_frame(Reader& from, bool is_there) {
  FrameMessage frame;
  frame.slot = from.get<std::int32_t>();
  frame.headings = from.get<std::int32_t>();
  frame.index = from.get<std::int64_t>();
  frame.t = from.get<double>();
  PlaneMap::Matrix matrix;
  from.doubles(matrix.data(), 9);
  if (!is_there) return std::nullopt;
  try {
    frame.plane_map = PlaneMap(matrix);
  } catch (const std::invalid_argument& error) {
    throw MessageError(error.what());
  }
  return frame;
}

void write_measurement(Writer& to, const std::optional<Measurement>& measurement) {
  const Measurement& m = measurement ? *measurement : Measurement{};
  to << m.pose << m.covariance.value_or(PoseCovariance::Zero()) << m.misfit << m.signal_to_noise;
}

std::vector<Point> read_blobs(Reader& from, std::uint32_t count) {
  std::vector<Point> blobs(count);
  for (Point& blob : blobs) {
    blob.x = from.get<double>();
    blob.y = from.get<double>();
    check_figure(blob.x, "a blob", measure_bit);
    check_figure(blob.y, "a blob", measure_bit);
  }
  return blobs;
}

}  // namespace

const char* slot_of(StageBit stage) {
  switch (stage) {
    case parameters_bit:
      return "estimate_parameters";
    case measure_bit:
      return "measure";
    case estimate_bit:
      return "estimate_state";
    case control_bit:
      return "control";
  }
  throw std::logic_error("no stage");
}

std::string to_bytes(const StepMessage& m) {
  const Estimate estimate = m.estimate.value_or(Estimate{{}, PoseCovariance::Zero(), {}});
  const Sample sample = m.sample.value_or(Sample{{AxisMatrix::Zero(), {0, 0, 0}}, 0});
  Writer to;
  to << m.k << m.t << m.last_u << m.done << parts_of(m);
  to << static_cast<std::uint32_t>(m.missed.value_or(DetectionResult::detected));
  to << static_cast<std::uint32_t>(m.blobs.size());
  to << static_cast<std::uint32_t>(estimate.state.size()) << m.next_slot;
  write_frame(to, m.frame.value_or(FrameMessage{}));
  to << sample.k << sample.regression.phi;
  to.doubles(sample.regression.y.data(), 3);
  to << m.parameters.value_or(AxisMatrix::Zero());
  to << m.standard_errors_unscaled.value_or(AxisMatrix::Zero());
  write_measurement(to, m.measurement);
  to << estimate.pose << estimate.covariance << m.u.value_or(Input{});
  for (const Point& blob : m.blobs) to << blob.x << blob.y;
  to.doubles(estimate.state.data(), estimate.state.size());
  return to.take();
}

StepMessage message_from(const char* bytes, std::size_t size, std::size_t pixel_bytes) {
  Reader from(bytes, size);
  StepMessage m;
  m.k = from.get<std::int64_t>();
  m.t = from.get<double>();
  m.last_u = from.input();
  m.done = from.get<std::uint32_t>();
  const auto parts = from.get<std::uint32_t>();
  const auto missed = from.get<std::uint32_t>();
  const auto n_blobs = from.get<std::uint32_t>();
  const auto n_states = from.get<std::uint32_t>();
  m.next_slot = from.get<std::uint32_t>();
  if (m.done > all_stages || parts > all_parts || n_blobs > most_blobs ||
      missed > static_cast<std::uint32_t>(DetectionResult::small_markers)) {
    throw MessageError("a message with choices or counts that there are not");
  }
  if (n_states > most_states) {
    throw MessageError("the further state must have at most " + std::to_string(most_states) +
                           " numbers, got " + std::to_string(n_states),
                       estimate_bit);
  }
  m.frame = read_frame(from, parts & frame_part);
  Sample sample;
  sample.k = from.get<std::int64_t>();
  sample.regression.phi = from.matrix<AxisMatrix>();
  from.doubles(sample.regression.y.data(), 3);
  const auto parameters = from.matrix<AxisMatrix>();
  const auto errors = from.matrix<AxisMatrix>();
  Measurement measurement;
  measurement.pose = from.pose();
  const auto covariance = from.matrix<PoseCovariance>();
  measurement.misfit = from.get<double>();
  measurement.signal_to_noise = from.get<double>();
  Estimate estimate;
  estimate.pose = from.pose();
  estimate.covariance = from.matrix<PoseCovariance>();
  const Input u = from.input();
  const std::size_t numbers = 2 * std::size_t{n_blobs} + n_states;
  const std::size_t pixels = m.frame && m.frame->slot < 0 ? pixel_bytes : 0;
  if (from.left() != numbers * sizeof(double) + pixels) {
    throw MessageError("a message of another length than it says");
  }
  m.blobs = read_blobs(from, n_blobs);
  estimate.state.resize(n_states);
  from.doubles(estimate.state.data(), n_states);
  m.has_frame = parts & has_frame_part;
  if (parts & sample_part) m.sample = sample;
  if (parts & parameters_part) m.parameters = parameters;
  if (parts & errors_part) m.standard_errors_unscaled = errors;
  if (parts & measurement_part) m.measurement = measurement;
  if (m.measurement && parts & covariance_part) m.measurement->covariance = covariance;
  if (parts & missed_part) m.missed = static_cast<DetectionResult>(missed);
  if (parts & estimate_part) m.estimate = std::move(estimate);
  if (parts & input_part) m.u = u;
  check_numbers(m);
  return m;
}

}  // namespace robsim
