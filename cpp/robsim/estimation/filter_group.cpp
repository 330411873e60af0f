#include "robsim/estimation/filter_group.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "robsim/base/simd/cpu_path.hpp"
#include "robsim/base/simd/lanes.hpp"

namespace robsim {

using simd::Lanes;

namespace {

// The limit of the mean variance under forgetting without excitation, in units of the variance of
// the noise.
constexpr double maximum_variance = 1e9;

constexpr int lane_count = Lanes::count;
constexpr int robot_parameters = 5;  // per axis of the robot model: the case that must be fast

constexpr double zero = 0;
constexpr double one = 1;

ROBSIM_INLINE Lanes gathered(const double* const* rows, int i = 0) {
  return {rows[0][i], rows[1][i], rows[2][i], rows[3][i]};
}

// NaN propagates to the sum; numbers up to 1e100 do not add up to infinity.
bool has_nan(const double* row, int n, double output) {
  return std::isnan(std::accumulate(row, row + n, output));
}

}  // namespace

// One sample of each filter. In lanes that skip the update, and in lanes without a filter, phi = 0,
// y = 0 and forgetting = 1 leave everything unchanged.
struct FilterGroup::Sample {
  const double* phi[lane_count];
  const double* y[lane_count];
  const double* forgetting[lane_count];
};

FilterGroup::FilterGroup(int parameters, int filters, double forgetting, double initial_covariance)
    : parameters_(parameters),
      filters_(filters),
      forgetting_(forgetting),
      covariance_limit_(parameters * std::max(maximum_variance, initial_covariance)),
      theta_(at(parameters, 0), 0),
      D_(at(parameters, 0), initial_covariance),
      U_(column(parameters), 0),
      phi_(at(parameters, 0)),
      gain_(at(parameters, 0)),
      no_regressors_(static_cast<std::size_t>(parameters), 0) {}

// Updates with one sample and returns the maximum trace of P. `n` is the number of parameters, a
// constant where the caller knows it; phi and gain are buffers for n vectors.
ROBSIM_INLINE double FilterGroup::update_one(const Sample& sample, double* phi, double* gain,
                                             int n) {
  Lanes innovation = gathered(sample.y);
  ROBSIM_UNROLL
  for (int j = 0; j < n; ++j) {
    const Lanes x = gathered(sample.phi, j);
    innovation = innovation - x * Lanes::load(&theta_[at(j, 0)]);
    x.store(phi + lane_count * j);
  }
  Lanes alpha = gathered(sample.forgetting);
  const Lanes per_forgetting = Lanes::all(1) / alpha;
  Lanes per_alpha = per_forgetting;
  Lanes trace = Lanes::all(0);
  ROBSIM_UNROLL
  for (int j = 0; j < n; ++j) {
    double* const U = U_.data() + column(j);
    // f = U' phi,  v = D f,  alpha_j = alpha_(j-1) + f_j v_j
    Lanes f = Lanes::load(phi + lane_count * j);
    ROBSIM_UNROLL
    for (int i = 0; i < j; ++i) {
      f = f + Lanes::load(U + lane_count * i) * Lanes::load(phi + lane_count * i);
    }
    const Lanes d = Lanes::load(&D_[at(j, 0)]);
    const Lanes v = d * f;
    const Lanes previous = alpha;
    alpha = alpha + f * v;
    // U_ij <- U_ij - b_i f_j/alpha_(j-1),  b_i <- b_i + U_ij v_j,  b_j = v_j
    const Lanes c = f * per_alpha;
    Lanes square = Lanes::all(1);
    ROBSIM_UNROLL
    for (int i = 0; i < j; ++i) {
      const Lanes u = Lanes::load(U + lane_count * i);
      const Lanes b = Lanes::load(gain + lane_count * i);
      const Lanes changed = u - b * c;
      square = square + changed * changed;
      changed.store(U + lane_count * i);
      (b + u * v).store(gain + lane_count * i);
    }
    v.store(gain + lane_count * j);
    // D_j <- D_j alpha_(j-1)/(alpha_j lambda)
    per_alpha = Lanes::all(1) / alpha;
    const Lanes changed = d * (previous * per_alpha * per_forgetting);
    changed.store(&D_[at(j, 0)]);
    trace = trace + changed * square;
  }
  // K = b/alpha_n,  theta <- theta + K innovation
  innovation = innovation * per_alpha;
  ROBSIM_UNROLL
  for (int j = 0; j < n; ++j) {
    double* const theta = &theta_[at(j, 0)];
    (Lanes::load(theta) + Lanes::load(gain + lane_count * j) * innovation).store(theta);
  }
  double traces[lane_count];
  trace.store(traces);
  return *std::max_element(traces, traces + lane_count);
}

ROBSIM_INLINE void FilterGroup::write_theta(double* theta, int n) const {
  for (int filter = 0; filter < filters_; ++filter) {
    ROBSIM_UNROLL
    for (int i = 0; i < n; ++i) *theta++ = theta_[at(i, filter)];
  }
}

ROBSIM_INLINE void FilterGroup::update_all(const Samples& samples, double* phi, double* gain,
                                           int n) {
  const double* const none = no_regressors_.data();
  for (std::int64_t k = 0; k < samples.count; ++k) {
    Sample sample{{none, none, none, none}, {&zero, &zero, &zero, &zero}, {&one, &one, &one, &one}};
    for (int filter = 0; filter < filters_; ++filter) {
      const std::int64_t i = k * samples.stride + filter;
      const double* const row = samples.phi + i * n;
      const double* const output = samples.y + i;
      if (samples.may_have_nan && has_nan(row, n, *output)) continue;
      sample.phi[filter] = row;
      sample.y[filter] = output;
      sample.forgetting[filter] = &forgetting_;
      ++samples_[static_cast<std::size_t>(filter)];
    }
    const double trace = update_one(sample, phi, gain, n);
    if (forgetting_ < 1 && trace > covariance_limit_) limit_covariance();
    if (samples.history) write_theta(samples.history + k * samples.stride * n, n);
  }
}

template <int n>
ROBSIM_INLINE void FilterGroup::update_fixed(FilterGroup& group, const Samples& samples) {
  double phi[n * lane_count], gain[n * lane_count];
  group.update_all(samples, phi, gain, n);
}

void FilterGroup::update(const Samples& samples) {
  if (parameters_ == robot_parameters) {
    ROBSIM_PICK (&FilterGroup::update_fixed<robot_parameters>)(*this, samples);
  } else {
    update_all(samples, phi_.data(), gain_.data(), parameters_);
  }
}

// Limits each D_j so that its part D_j |U_j|^2 of the trace of P is at most 1/n of the limit.
void FilterGroup::limit_covariance() {
  for (int filter = 0; filter < filters_; ++filter) {
    for (int j = 0; j < parameters_; ++j) {
      double square = 1;
      for (int i = 0; i < j; ++i) square += u(filter, i, j) * u(filter, i, j);
      double& D = D_[at(j, filter)];
      D = std::min(D, covariance_limit_ / parameters_ / square);
    }
  }
}

void FilterGroup::write_estimates(double* estimates) const { write_theta(estimates, parameters_); }

// P_ii = D_i + sum_(j>i) U_ij^2 D_j
ROBSIM_INLINE void FilterGroup::write_variances(double* variances, int n) const {
  ROBSIM_UNROLL
  for (int i = 0; i < n; ++i) {
    Lanes sum = Lanes::load(&D_[at(i, 0)]);
    ROBSIM_UNROLL
    for (int j = i + 1; j < n; ++j) {
      const Lanes u = Lanes::load(&U_[column(j) + at(i, 0)]);
      sum = sum + u * u * Lanes::load(&D_[at(j, 0)]);
    }
    double of_filter[lane_count];
    sum.store(of_filter);
    for (int filter = 0; filter < filters_; ++filter) variances[filter * n + i] = of_filter[filter];
  }
}

template <int n>
ROBSIM_INLINE void FilterGroup::write_fixed_variances(const FilterGroup& group, double* variances) {
  group.write_variances(variances, n);
}

void FilterGroup::write_standard_errors_unscaled(double* errors) const {
  if (parameters_ == robot_parameters) {
    ROBSIM_PICK (&FilterGroup::write_fixed_variances<robot_parameters>)(*this, errors);
  } else {
    write_variances(errors, parameters_);
  }
  Eigen::Map<Eigen::ArrayXd> values(errors, filters_ * parameters_);
  values = values.sqrt();
}

void FilterGroup::append_state(std::vector<double>& state) const {
  for (const auto* values : {&theta_, &D_, &U_}) {
    state.insert(state.end(), values->begin(), values->end());
  }
  state.insert(state.end(), samples_.begin(), samples_.end());  // exact up to 2^53
}

const double* FilterGroup::restore(const double* state) {
  for (auto* values : {&theta_, &D_, &U_}) {
    std::copy_n(state, values->size(), values->begin());
    state += values->size();
  }
  for (std::int64_t& count : samples_) count = static_cast<std::int64_t>(*state++);
  return state;
}

}  // namespace robsim
