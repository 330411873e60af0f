#include "robsim/simulation/remote/step_message.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <type_traits>

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

// The numbers of a matrix, row by row.
template <typename Matrix>
struct Numbers {
  std::array<double, Matrix::SizeAtCompileTime> at{};

  Numbers& operator=(const Matrix& matrix) {
    std::copy_n(matrix.data(), at.size(), at.begin());
    return *this;
  }
  operator Matrix() const { return Matrix(at.data()); }
};

// The begin of a message, byte by byte; missing values are 0.
struct FixedPart {
  std::int64_t k;
  double t;
  Input last_u;
  std::uint32_t done, parts, missed, n_blobs, n_states, next_slot;
  std::int32_t slot, headings;  // of the frame
  std::int64_t index;
  double frame_t;
  PlaneMap::Matrix plane_map;
  std::int64_t sample_k;
  Numbers<AxisMatrix> phi;
  Numbers<Eigen::Vector3d> y;
  Numbers<AxisMatrix> parameters, standard_errors_unscaled;
  Pose measured;
  Numbers<PoseCovariance> measured_covariance;
  double misfit, signal_to_noise;
  Pose estimated;
  Numbers<PoseCovariance> covariance;
  Input u;
};
static_assert(std::is_trivially_copyable_v<FixedPart> && sizeof(FixedPart) == 768, "no gaps");

void check_finite(const double* values, std::size_t count, const char* what, StageBit stage) {
  for (const double* value = values; value != values + count; ++value) {
    if (std::isfinite(*value)) continue;
    throw MessageError(std::string(what) + " must be finite, got " + to_text(*value), stage);
  }
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
  for (const Point& blob : m.blobs) {
    check_figure(blob.x, "a blob", measure_bit);
    check_figure(blob.y, "a blob", measure_bit);
  }
  if (m.u) {
    const double u[] = {m.u->u1, m.u->u2};
    check_finite(u, 2, "the input", control_bit);
  }
}

FrameMessage frame_from(const FixedPart& fixed) {
  try {
    return {fixed.slot, fixed.index, fixed.frame_t, fixed.headings, PlaneMap(fixed.plane_map)};
  } catch (const std::invalid_argument& error) {
    throw MessageError(error.what());
  }
}

void check_counts(const FixedPart& fixed) {
  if (fixed.done > all_stages || fixed.parts > all_parts || fixed.n_blobs > most_blobs ||
      fixed.missed > static_cast<std::uint32_t>(last_result)) {
    throw MessageError("a message with choices or counts that there are not");
  }
  if (fixed.n_states > most_states) {
    throw MessageError("the further state must have at most " + std::to_string(most_states) +
                           " numbers, got " + std::to_string(fixed.n_states),
                       estimate_bit);
  }
}

template <typename T>
void append(std::string& bytes, const T* values, std::size_t count) {
  bytes.append(reinterpret_cast<const char*>(values), count * sizeof(T));
}

template <typename T>
std::vector<T> taken(const char*& bytes, std::uint32_t count) {
  std::vector<T> values(count);
  if (count > 0) std::memcpy(static_cast<void*>(values.data()), bytes, count * sizeof(T));
  bytes += count * sizeof(T);
  return values;
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
  FixedPart fixed{};
  const auto has = [&](const auto& part, Part bit) {
    if (part) fixed.parts |= bit;
    return static_cast<bool>(part);
  };
  fixed.k = m.k;
  fixed.t = m.t;
  fixed.last_u = m.last_u;
  fixed.done = m.done;
  fixed.n_blobs = static_cast<std::uint32_t>(m.blobs.size());
  fixed.next_slot = m.next_slot;
  has(m.has_frame, has_frame_part);
  if (has(m.frame, frame_part)) {
    fixed.slot = m.frame->slot;
    fixed.headings = m.frame->headings;
    fixed.index = m.frame->index;
    fixed.frame_t = m.frame->t;
    fixed.plane_map = m.frame->plane_map.matrix();
  }
  if (has(m.sample, sample_part)) {
    fixed.sample_k = m.sample->k;
    fixed.phi = m.sample->regression.phi;
    fixed.y = m.sample->regression.y;
  }
  if (has(m.parameters, parameters_part)) fixed.parameters = *m.parameters;
  if (has(m.standard_errors_unscaled, errors_part)) {
    fixed.standard_errors_unscaled = *m.standard_errors_unscaled;
  }
  if (has(m.measurement, measurement_part)) {
    // All fields, so that a new one does not compile before it is in the message; the pair is not.
    const auto& [pose, covariance, misfit, signal_to_noise, pair, given] = *m.measurement;
    fixed.measured = pose;
    if (has(covariance, covariance_part)) fixed.measured_covariance = *covariance;
    fixed.misfit = misfit;
    fixed.signal_to_noise = signal_to_noise;
  }
  if (has(m.missed, missed_part)) fixed.missed = static_cast<std::uint32_t>(*m.missed);
  if (has(m.estimate, estimate_part)) {
    fixed.estimated = m.estimate->pose;
    fixed.covariance = m.estimate->covariance;
    fixed.n_states = static_cast<std::uint32_t>(m.estimate->state.size());
  }
  if (has(m.u, input_part)) fixed.u = *m.u;
  std::string bytes;
  append(bytes, &fixed, 1);
  append(bytes, m.blobs.data(), m.blobs.size());
  if (m.estimate) append(bytes, m.estimate->state.data(), m.estimate->state.size());
  return bytes;
}

StepMessage message_from(const char* bytes, std::size_t size, std::size_t pixel_bytes) {
  FixedPart fixed;
  if (size < sizeof fixed) throw MessageError("a message that is too short");
  std::memcpy(static_cast<void*>(&fixed), bytes, sizeof fixed);
  check_counts(fixed);
  const auto has = [&](Part bit) { return (fixed.parts & bit) != 0; };
  StepMessage m;
  if (has(frame_part)) m.frame = frame_from(fixed);
  const std::size_t pixels = m.frame && m.frame->slot < 0 ? pixel_bytes : 0;
  const std::size_t numbers = 2 * std::size_t{fixed.n_blobs} + fixed.n_states;
  if (size - sizeof fixed != numbers * sizeof(double) + pixels) {
    throw MessageError("a message of another length than it says");
  }
  const char* next = bytes + sizeof fixed;
  m.k = fixed.k;
  m.t = fixed.t;
  m.last_u = fixed.last_u;
  m.done = fixed.done;
  m.next_slot = fixed.next_slot;
  m.has_frame = has(has_frame_part);
  m.blobs = taken<Point>(next, fixed.n_blobs);
  if (has(sample_part)) m.sample = Sample{{fixed.phi, fixed.y}, fixed.sample_k};
  if (has(parameters_part)) m.parameters = fixed.parameters;
  if (has(errors_part)) m.standard_errors_unscaled = fixed.standard_errors_unscaled;
  if (has(measurement_part)) {
    m.measurement = Measurement{fixed.measured, {}, fixed.misfit, fixed.signal_to_noise};
    if (has(covariance_part)) m.measurement->covariance = fixed.measured_covariance;
  }
  if (has(missed_part)) m.missed = static_cast<DetectionResult>(fixed.missed);
  if (has(estimate_part)) {
    m.estimate = Estimate{fixed.estimated, fixed.covariance, taken<double>(next, fixed.n_states)};
  }
  if (has(input_part)) m.u = fixed.u;
  check_numbers(m);
  return m;
}

}  // namespace robsim
