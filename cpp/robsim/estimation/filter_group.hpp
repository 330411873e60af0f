#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace robsim {

/// Up to four recursive least squares filters, updated together in the lanes of vectors.
/// `RecursiveLeastSquares` names the source of the equations and checks the arguments.
class FilterGroup {
 public:
  static constexpr int maximum_filters = 4;

  FilterGroup(int parameters, int filters, double forgetting, double initial_covariance);

  int filters() const { return filters_; }

  /// A sequence of samples: phi has the regressors of the first filter, of the second, ..., y their
  /// outputs. Consecutive samples are `stride` outputs apart.
  struct Samples {
    const double* phi;
    const double* y;
    double* history;  // optional: receives the estimates after each sample, in the order of phi
    std::int64_t count;
    std::int64_t stride;
    bool may_have_nan;  // a filter with NaN in its sample skips the update
  };
  void update(const Samples& samples);

  /// The estimates, and the square roots of the diagonal of P, filter by filter.
  void write_estimates(double* estimates) const;
  void write_standard_errors_unscaled(double* errors) const;

  /// The limit of the trace of P of a filter.
  double covariance_limit() const { return covariance_limit_; }

  // P = U D U': the elements of U above its diagonal, which is 1, and the diagonal of D.
  double u(int filter, int i, int j) const { return U_[column(j) + at(i, filter)]; }
  double d(int filter, int j) const { return D_[at(j, filter)]; }
  std::int64_t samples(int filter) const { return samples_[static_cast<std::size_t>(filter)]; }

  /// What updates change, as numbers; `restore` reads them and returns what follows.
  void append_state(std::vector<double>& state) const;
  const double* restore(const double* state);

 private:
  // Each element of theta, D and U is stored for the four filters side by side, U by columns.
  static std::size_t at(int i, int filter) {
    return static_cast<std::size_t>(i * maximum_filters + filter);
  }
  static std::size_t column(int j) { return at(j * (j - 1) / 2, 0); }

  struct Sample;
  double update_one(const Sample& sample, double* phi, double* gain, int n);
  void update_all(const Samples& samples, double* phi, double* gain, int n);
  template <int n>
  static void update_fixed(FilterGroup& group, const Samples& samples);
  void write_theta(double* theta, int n) const;
  void limit_covariance();
  void write_variances(double* variances, int n) const;
  template <int n>
  static void write_fixed_variances(const FilterGroup& group, double* variances);

  int parameters_;
  int filters_;
  double forgetting_;
  double covariance_limit_;
  std::vector<double> theta_, D_, U_;
  std::vector<double> phi_, gain_;     // buffers of an update
  std::vector<double> no_regressors_;  // zeros, for a filter that skips the update
  std::array<std::int64_t, maximum_filters> samples_{};
};

}  // namespace robsim
