#include <variant>

#include "python/values.hpp"
#include "robsim/estimation/least_squares.hpp"
#include "robsim/simulation/robot/stages.hpp"

using namespace robsim;
using namespace robsim::bindings;

namespace {

using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// One filter has vectors, several have rows.
Shape theta_shape(const RecursiveLeastSquares& self) {
  return self.n_filters() == 1 ? Shape{self.n_parameters()}
                               : Shape{self.n_filters(), self.n_parameters()};
}

// The numbers that a method writes, shaped as theta.
template <void (RecursiveLeastSquares::*write)(double*) const>
py::array_t<double> written(const RecursiveLeastSquares& self) {
  py::array_t<double> values(theta_shape(self));
  (self.*write)(values.mutable_data());
  return read_only(values);
}

py::array_t<double> covariance_of(const RecursiveLeastSquares& self) {
  std::vector<double> values;
  for (int filter = 0; filter < self.n_filters(); ++filter) {
    const Eigen::MatrixXd P = self.covariance(filter);
    values.insert(values.end(), P.data(), P.data() + P.size());
  }
  Shape shape = theta_shape(self);
  shape.push_back(self.n_parameters());
  return to_array(values.data(), shape);
}

using Counts = std::variant<std::int64_t, py::array_t<std::int64_t>>;

Counts sample_counts_of(const RecursiveLeastSquares& self) {
  if (self.n_filters() == 1) return self.samples(0);
  py::array_t<std::int64_t> samples(self.n_filters());
  for (int i = 0; i < self.n_filters(); ++i) samples.mutable_at(i) = self.samples(i);
  return samples;
}

std::vector<double> state_of(const RecursiveLeastSquares& self) { return self.state(); }

void reset(RecursiveLeastSquares& self) { self.reset(); }

std::string text_of(const Shape& shape) {
  return shape_text(shape.data(), static_cast<py::ssize_t>(shape.size()));
}

py::array_t<double> recursion(double a1, double a2, const ArrayLike& force) {
  const std::string expected = "an array of shape (n,) or (n, m)";
  const Doubles array = numbers_from(force, "force", std::nullopt, expected);
  if (array.ndim() != 1 && array.ndim() != 2) {
    throw py::value_error("force must be " + expected + ", got " + describe(force));
  }
  py::array_t<double> s(Shape(array.shape(), array.shape() + array.ndim()));
  second_order_recursion(a1, a2, array.data(), s.mutable_data(),
                         static_cast<std::size_t>(array.shape(0)),
                         array.ndim() == 2 ? static_cast<std::size_t>(array.shape(1)) : 1);
  return s;
}

// Regressors or outputs of one sample or, with a dimension more, of many.
Doubles samples_from(const ArrayLike& value, const char* name, const char* what, Shape single) {
  Shape many = single;
  many.insert(many.begin(), -1);
  const std::string one = text_of(single);
  const std::string expected =
      std::string(what) + ": " + one + " for a sample, (N, " + one.substr(1) + " for N samples";
  const Doubles array = numbers_from(value, name, std::nullopt, expected);
  const bool is_many = array.ndim() == static_cast<py::ssize_t>(many.size());
  return numbers_from(value, name, is_many ? many : single, expected);
}

py::array_t<double> update(RecursiveLeastSquares& self, const ArrayLike& phi_value,
                           const ArrayLike& y_value) {
  const Shape single = theta_shape(self);
  const Doubles phi = samples_from(phi_value, "phi", "regressors", single);
  Shape outputs(phi.shape(), phi.shape() + phi.ndim() - 1);
  const Doubles y = numbers_from(
      y_value, "y", outputs,
      outputs.empty() ? "one output, a number" : "outputs of shape " + text_of(outputs));
  const bool is_many = phi.ndim() > static_cast<py::ssize_t>(single.size());
  py::array_t<double> history(Shape(phi.shape(), phi.shape() + phi.ndim()));
  self.update(phi.data(), y.data(), is_many ? phi.shape(0) : 1, history.mutable_data());
  return read_only(history);
}

LeastSquaresFit fit(const ArrayLike& phi_value, const ArrayLike& y_value) {
  const Doubles phi = numbers_from(phi_value, "phi", Shape{-1, -1}, "regressors of shape (N, n)");
  const Doubles y =
      numbers_from(y_value, "y", Shape{phi.shape(0)}, "one output a sample, shape (N,)");
  return least_squares(Eigen::Map<const Rows>(phi.data(), phi.shape(0), phi.shape(1)),
                       Eigen::Map<const Eigen::VectorXd>(y.data(), y.size()));
}

template <typename From, typename To>
using copy_const = std::conditional_t<std::is_const_v<From>, const To, To>;

// The state that each update changes, for one thread at a time: a run may use it.
template <typename Result, typename Filters, typename... Arguments>
auto alone(Result (*function)(Filters&, Arguments...)) {
  return
      [function](copy_const<Filters, GuardedLeastSquares>& self, Arguments... arguments) -> Result {
        const ThreadGuard::Look look(self.guard());
        return function(self, arguments...);
      };
}

using RecursiveClass = Class<GuardedLeastSquares, std::shared_ptr<GuardedLeastSquares>>;

// It changes with each update: equal are filters that go on alike. There is no hash.
void define_recursive_value(RecursiveClass& cls) {
  using Rls = GuardedLeastSquares;
  const auto make = [](int n_parameters, int n_filters, double forgetting, double covariance,
                       const std::vector<double>& state) {
    auto filter = std::make_shared<Rls>(n_parameters, n_filters, forgetting, covariance);
    filter->restore(state);
    return filter;
  };
  const Fields fields(make, Field("n_parameters", &Rls::n_parameters),
                      Field("n_filters", &Rls::n_filters), Field("forgetting", &Rls::forgetting),
                      Field("initial_covariance", &Rls::initial_covariance),
                      Field("state", alone(state_of)));
  define_equality(cls, fields);
  define_pickle(cls, fields);
  cls.def("__repr__", [](const Rls& self) {
    const ThreadGuard::Look look(self.guard());
    return py::str("<RecursiveLeastSquares: {} parameters, {} filter{}, {} samples>")
        .format(self.n_parameters(), self.n_filters(), self.n_filters() == 1 ? "" : "s",
                sample_counts_of(self));
  });
}

void bind_fit(py::module_& module) {
  Class<LeastSquaresFit> fit(public_in(module, "robsim.estimation"), "LeastSquaresFit",
                             R"(
Result of `least_squares`.

Examples
--------
>>> fit = robsim.estimation.least_squares([[1, 0], [0, 1], [1, 1]], [1, 2, 3.3])
>>> fit.theta.round(3), fit.standard_errors.round(3)
(array([1.1, 2.1]), array([0.141, 0.141]))
)");
  define_repr(fit,
              "<LeastSquaresFit: theta {0.theta}, rank {0.rank}, condition {0.condition:.3g}, "
              "residual rms {0.residual_rms:.3g}>");
  define_record(fit,
                members<LeastSquaresFit>(
                    nullptr,
                    Field("theta", &LeastSquaresFit::theta,
                          "array (n,): the parameters, NaN if the samples do not determine them."),
                    Field("rank", &LeastSquaresFit::rank, "int: number of independent regressors."),
                    Field("condition", &LeastSquaresFit::condition,
                          "float: condition number of the regressors, scaled to length 1."),
                    Field("residual_rms", &LeastSquaresFit::residual_rms,
                          "float: root mean square of y - phi theta."),
                    Field("standard_errors_unscaled", &LeastSquaresFit::standard_errors_unscaled,
                          "array (n,): standard errors of theta in units of the standard deviation "
                          "of the noise;\ninf if the samples do not determine them."),
                    Field("standard_errors", &LeastSquaresFit::standard_errors,
                          "array (n,): standard errors of theta, with the noise estimated from the "
                          "residuals.")));
}

}  // namespace

void bind_estimation(py::module_& module) {
  module.attr("rank_tolerance") = rank_tolerance;

  const RecursiveLeastSquares defaults(1);
  RecursiveClass recursive(public_in(module, "robsim"), "RecursiveLeastSquares", R"(
Recursive least squares with forgetting, for one or more parallel filters.

Parameters
----------
n_parameters : int
    Number of parameters of a filter.
n_filters : int
    Number of filters: 3 for the axes of a robot, 3 R for R runs.
forgetting : float
    Forgetting factor, within 1e-10..1; 1 = no forgetting.
initial_covariance : float
    The initial P is this times the identity matrix, at most 1e50; the initial theta is 0.

Raises
------
ValueError
    For values outside these ranges.
RuntimeError
    If the estimator is read, updated or reset while a run in another thread uses it.
    ``sim.trace.parameters`` can be read meanwhile.

Notes
-----
theta minimises the sum of forgetting^(N-k) (y(k) - phi(k) theta)^2 over the samples k = 1..N,
plus ``forgetting^N |theta|^2 / initial_covariance``. The covariance is kept as P = U D U' (Bierman,
Factorization Methods for Discrete Sequential Estimation, 1977, ch. V), so that rounding cannot make
P asymmetric or indefinite, for any number of samples.

Without excitation, as with a constant input, forgetting lets P grow without bound. The filter
limits the trace of P to 1e9 per parameter, or to its initial value if that is larger. The variances
D of single columns of U are limited accordingly. The limit adds information along these columns
only. The estimates do not change, and excited directions are forgotten as before. When excitation
returns, the filter adapts like a new filter. Below the limit, the filter is the textbook filter.
With a forgetting of 1 a filter follows a change of the parameters more and more slowly as samples
accumulate.

Examples
--------
>>> rls = robsim.RecursiveLeastSquares(2)
>>> for phi, y in [((1, 0), 1.0), ((0, 1), 2.0), ((1, 1), 3.3)]:
...     theta = rls.update([phi], [y])
>>> theta.round(3)
array([[1.1, 2.1]])
)");
  recursive
      .def(py::init<int, int, double, double>(), "n_parameters"_a, py::kw_only(), "n_filters"_a = 1,
           "forgetting"_a = defaults.forgetting(),
           "initial_covariance"_a = defaults.initial_covariance())
      .def("update", alone(update), "phi"_a, "y"_a, R"(
Update every filter with one sample, or with N samples in sequence.

Parameters
----------
phi : array (n_parameters,) or (N, n_parameters); for several filters (n_filters, n_parameters) or \
(N, n_filters, n_parameters)
    Regressors. A filter with NaN in its regressors or its output skips the update.
y : array, shaped as phi without its last dimension
    Outputs.

Returns
-------
array, shaped as phi
    The estimates after each sample. A skipped update leaves them unchanged.

Raises
------
TypeError, ValueError
    For wrong shapes and for numbers beyond 1e50; the filters then stay unchanged.
)")
      .def_property_readonly("theta", alone(written<&RecursiveLeastSquares::write_estimates>),
                             "array (n_parameters,) or (n_filters, n_parameters): the estimates.")
      .def_property_readonly(
          "P", alone(covariance_of),
          "array (n_parameters, n_parameters), for several filters (n_filters, n_parameters, "
          "n_parameters):\n"
          "covariance of the estimates in units of the variance of the output noise.")
      .def_property_readonly(
          "standard_errors_unscaled",
          alone(written<&RecursiveLeastSquares::write_standard_errors_unscaled>),
          "array, shaped as theta: standard errors of the estimates in units of the standard\n"
          "deviation of the output noise, the square roots of the diagonal of P.")
      .def_property_readonly(
          "n_samples", alone(sample_counts_of),
          "int, or array (n_filters,) of int: number of samples used, without skipped updates.")
      .def_property_readonly("forgetting", &RecursiveLeastSquares::forgetting,
                             "float: forgetting factor.")
      .def_property_readonly("initial_covariance", &RecursiveLeastSquares::initial_covariance,
                             "float: the initial P is this times the identity matrix.")
      .def("reset", alone(reset), "Return to the initial state.");
  define_recursive_value(recursive);

  bind_fit(module);
  public_in(module, "robsim._core")
      .def("second_order_recursion", &recursion, "a1"_a, "a2"_a, "force"_a, R"(
Return s(k) = a1 s(k-1) + a2 s(k-2) + force(k), column by column; s = 0 before the first.

Parameters
----------
a1, a2 : float
    The parameters.
force : array (n,) or (n, m)
    The driving term.

Returns
-------
array, shaped as force
    The path s.
)");
  public_in(module, "robsim.estimation").def("least_squares", &fit, "phi"_a, "y"_a, R"(
Return the theta that minimises the sum of squares of y - phi theta.

Parameters
----------
phi : array (N, n)
    Regressors, one sample a row.
y : array (N,)
    Outputs.

Returns
-------
LeastSquaresFit
    theta, rank, condition, residual_rms, standard_errors_unscaled, standard_errors.

Notes
-----
The method is Householder QR of blocks of rows, followed by QR with column pivoting of the triangle
(Golub and Van Loan, Matrix Computations, 5.2.2 and 5.4.2). The standard errors assume white noise
in y.

Examples
--------
>>> robsim.estimation.least_squares([[1, 0], [0, 1], [1, 1]], [1, 2, 3.3])
<LeastSquaresFit: theta [1.1 2.1], rank 2, condition 1.73, residual rms 0.1>
)");
}
