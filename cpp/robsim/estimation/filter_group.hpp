#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace robsim {

/// Up to four recursive filters of least squares, of which a processor updates all at once.
/// `RecursiveLeastSquares` has the equations' source and the checks.
class FilterGroup {
 public:
  static constexpr int most_filters = 4;

  FilterGroup(int parameters, int filters, double forgetting, double initial_covariance);

  int filters() const { return filters_; }

  /// Samples one after the other: in phi the regressors of the first filter, of the second, ...,
  /// in y their outputs. From one sample to the next there are `stride` outputs.
  struct Samples {
    const double* phi;
    const double* y;
    double* history;  // if not null, the estimates after each sample go there, in the order of phi
    std::int64_t count;
    std::int64_t stride;
    bool may_have_nan;  // a filter holds where its regressors or its output have one
  };
  void update(const Samples& samples);

  /// The estimates, and the square roots of the diagonal of P, filter by filter.
  void write_estimates(double* estimates) const;
  void write_standard_errors_unscaled(double* errors) const;

  /// What the trace of P of a filter never exceeds.
  double covariance_limit() const { return covariance_limit_; }

  // P = U D U': above the diagonal of U, which is 1, and on that of D.
  double u(int filter, int i, int j) const { return U_[column(j) + place(i, filter)]; }
  double d(int filter, int j) const { return D_[place(j, filter)]; }
  std::int64_t samples(int filter) const { return samples_[static_cast<std::size_t>(filter)]; }

 private:
  // Each number of theta, D and U stands there for the four filters side by side, those of U column
  // by column.
  static std::size_t place(int i, int filter) {
    return static_cast<std::size_t>(i * most_filters + filter);
  }
  static std::size_t column(int j) { return place(j * (j - 1) / 2, 0); }

  struct Sample;
  double update_one(const Sample& sample, double* phi, double* gain, int n);
  void update_all(const Samples& samples, double* phi, double* gain, int n);
  template <int n>
  void update_fixed(const Samples& samples);
  template <int n>
  void update_fixed_avx2(const Samples& samples);
  void write_theta(double* theta, int n) const;
  void limit_covariance();
  void write_variances(double* variances, int n) const;

  int parameters_;
  int filters_;
  double forgetting_;
  double covariance_limit_;
  std::vector<double> theta_, D_, U_;
  std::vector<double> phi_, gain_;     // room for an update
  std::vector<double> no_regressors_;  // of a filter that holds: zeros
  std::array<std::int64_t, most_filters> samples_{};
};

}  // namespace robsim
