#include <pybind11/eigen.h>

#include "numpy.hpp"
#include "robsim/estimation/least_squares.hpp"
#include "robsim/estimation/recursive_least_squares.hpp"

namespace py = pybind11;
using namespace robsim;
using namespace robsim::bindings;

namespace {

// One filter speaks in vectors, several in rows.
Shape phi_shape(const RecursiveLeastSquares& self) {
  return self.filters() == 1 ? Shape{self.parameters()} : Shape{self.filters(), self.parameters()};
}

py::array_t<double> theta_of(const RecursiveLeastSquares& self) {
  return to_array(self.theta().data(), phi_shape(self));
}

py::array_t<double> update(RecursiveLeastSquares& self, const py::object& phi_value,
                           const py::object& y_value) {
  const Shape shape = phi_shape(self);
  const std::string filters = std::to_string(self.filters());
  const std::string parameters = std::to_string(self.parameters());
  const bool single = self.filters() == 1;
  const Doubles phi = doubles_from(phi_value, "phi", shape,
                                   "regressors of shape (" + (single ? "" : filters + ", ") +
                                       parameters + (single ? ",)" : ")"));
  const Doubles y =
      doubles_from(y_value, "y", single ? Shape{} : Shape{self.filters()},
                   single ? "one output, a number" : "outputs of shape (" + filters + ",)");
  self.update(
      Eigen::Map<const RecursiveLeastSquares::Rows>(phi.data(), self.filters(), self.parameters()),
      Eigen::Map<const Eigen::VectorXd>(y.data(), self.filters()));
  return theta_of(self);
}

LeastSquaresFit fit(const py::object& phi_value, const py::object& y_value) {
  const Doubles phi = doubles_from(phi_value, "phi", Shape{-1, -1}, "regressors of shape (N, n)");
  const Doubles y =
      doubles_from(y_value, "y", Shape{phi.shape(0)}, "one output a sample, shape (N,)");
  return least_squares(
      Eigen::Map<const RecursiveLeastSquares::Rows>(phi.data(), phi.shape(0), phi.shape(1)),
      Eigen::Map<const Eigen::VectorXd>(y.data(), y.size()));
}

}  // namespace

void bind_estimation(py::module_& module) {
  const RecursiveLeastSquares defaults(1);
  py::class_<RecursiveLeastSquares, std::shared_ptr<RecursiveLeastSquares>>(
      module, "RecursiveLeastSquares", R"(
Recursive least squares with forgetting, for one filter or several side by side.

Parameters
----------
parameters : int
    Number of parameters of a filter.
filters : int
    Number of filters.
forgetting : float
    Forgetting factor, 0 < forgetting <= 1; 1 forgets nothing.
initial_covariance : float
    P at the start is this times the unit matrix; theta is 0.

Raises
------
ValueError
    For values outside these ranges.

Notes
-----
The covariance is kept as P = U D U' (Bierman, Factorization Methods for Discrete Sequential
Estimation, 1977, ch. V): no rounding can make it asymmetric or negative.
)")
      .def(py::init<int, int, double, double>(), py::arg("parameters"), py::kw_only(),
           py::arg("filters") = 1, py::arg("forgetting") = defaults.forgetting(),
           py::arg("initial_covariance") = defaults.initial_covariance())
      .def("update", &update, py::arg("phi"), py::arg("y"), R"(
Take in one sample of every filter.

Parameters
----------
phi : array (parameters,), or (filters, parameters) for several filters
    Regressors.
y : float, or array (filters,) for several filters
    Outputs.

Returns
-------
array, shaped as phi
    The estimates now.

Raises
------
TypeError, ValueError
    For other shapes, NaN or infinity; the filter stays what it was.
)")
      .def_property_readonly("theta", &theta_of, "array, shaped as phi: the estimates.")
      .def_property_readonly(
          "P",
          [](const RecursiveLeastSquares& self) {
            std::vector<double> values;
            for (int i = 0; i < self.filters(); ++i) {
              const Eigen::MatrixXd P = self.covariance(i);
              values.insert(values.end(), P.data(), P.data() + P.size());
            }
            Shape shape{self.parameters(), self.parameters()};
            if (self.filters() > 1) shape.insert(shape.begin(), self.filters());
            return to_array(values.data(), shape);
          },
          "array (parameters, parameters), for several filters (filters, parameters, parameters):\n"
          "covariance of the estimates in units of the variance of the output noise.")
      .def_property_readonly("forgetting", &RecursiveLeastSquares::forgetting,
                             "float: forgetting factor.")
      .def_property_readonly("initial_covariance", &RecursiveLeastSquares::initial_covariance,
                             "float: P at the start is this times the unit matrix.")
      .def("reset", &RecursiveLeastSquares::reset, "Go back to the start.");

  py::class_<LeastSquaresFit>(module, "LeastSquaresFit", "What `least_squares` found.")
      .def_property_readonly(
          "theta",
          [](const LeastSquaresFit& self) {
            return to_array(self.theta.data(), {self.theta.size()});
          },
          "array (n,): the parameters, NaN where the samples say nothing.")
      .def_readonly("rank", &LeastSquaresFit::rank, "int: number of independent regressors.")
      .def_readonly(
          "condition", &LeastSquaresFit::condition,
          "float: condition of the regressors, scaled to length 1: an estimate, from below.")
      .def_readonly("residual_rms", &LeastSquaresFit::residual_rms,
                    "float: root mean square of y - phi theta.");

  module.def("least_squares", &fit, py::arg("phi"), py::arg("y"), R"(
Return the theta that minimises the squares of y - phi theta.

Parameters
----------
phi : array (N, n)
    Regressors, one sample a row.
y : array (N,)
    Outputs.

Returns
-------
LeastSquaresFit
    theta, rank, condition, residual_rms.

Notes
-----
Householder QR with column pivoting (Golub and Van Loan, Matrix Computations, 5.4.2).
)");
}
