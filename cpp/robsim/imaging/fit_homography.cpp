#include "robsim/imaging/plane_map.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace robsim {

namespace {

using Homography = Eigen::Matrix3d;
using Parameters = Eigen::Matrix<double, 8, 1>;  // row by row; the ninth entry is 1
using Points = Eigen::Matrix<double, 2, Eigen::Dynamic>;
using Equations = Eigen::Matrix<double, Eigen::Dynamic, 8>;

constexpr int most_iterations = 50;
constexpr double converged = 1e-13;
constexpr double flattest = 1e-3;  // pivot of the equations as a fraction of the largest one
constexpr double worst_fit = 0.1;  // rms distance as a fraction of the spread of the positions

// Points with their centroid at 0 and a mean square of 1 for each coordinate.
struct Normalised {
  explicit Normalised(const std::vector<Point>& from)
      : points(2, static_cast<Eigen::Index>(from.size())) {
    for (Eigen::Index i = 0; i < points.cols(); ++i) {
      const Point& p = from[static_cast<std::size_t>(i)];
      points.col(i) << p.x, p.y;
    }
    const Eigen::Vector2d centroid = points.rowwise().mean();
    points.colwise() -= centroid;
    const double scale = std::sqrt(2 * static_cast<double>(points.cols()) / points.squaredNorm());
    points *= scale;
    to_normalised << scale, 0, -scale * centroid.x(), 0, scale, -scale * centroid.y(), 0, 0, 1;
  }

  Points points;
  Homography to_normalised;
};

// Linear equations J h = r, two for each point.
struct Linearised {
  Equations J;
  Eigen::VectorXd r;
};

Linearised linear(const Points& from, const Points& to) {
  Linearised system{Equations::Zero(2 * from.cols(), 8), Eigen::VectorXd(2 * from.cols())};
  for (Eigen::Index i = 0; i < from.cols(); ++i) {
    const double u = from(0, i), v = from(1, i);
    for (Eigen::Index axis = 0; axis < 2; ++axis) {
      const double x = to(axis, i);
      // h0 u + h1 v + h2 = x (h6 u + h7 v + 1), and the same of y
      system.J.row(2 * i + axis).segment<3>(3 * axis) << u, v, 1;
      system.J.row(2 * i + axis).tail<2>() << -u * x, -v * x;
      system.r(2 * i + axis) = x;
    }
  }
  return system;
}

Linearised around(const Parameters& h, const Points& from, const Points& to) {
  Linearised system{Equations::Zero(2 * from.cols(), 8), Eigen::VectorXd(2 * from.cols())};
  for (Eigen::Index i = 0; i < from.cols(); ++i) {
    const double u = from(0, i), v = from(1, i);
    const double w = h(6) * u + h(7) * v + 1;
    for (Eigen::Index axis = 0; axis < 2; ++axis) {
      // x = (h0 u + h1 v + h2) / (h6 u + h7 v + 1), and the same of y
      const double x = (h(3 * axis) * u + h(3 * axis + 1) * v + h(3 * axis + 2)) / w;
      system.J.row(2 * i + axis).segment<3>(3 * axis) << u / w, v / w, 1 / w;
      system.J.row(2 * i + axis).tail<2>() << -u * x / w, -v * x / w;
      system.r(2 * i + axis) = to(axis, i) - x;
    }
  }
  return system;
}

Parameters start(const Points& from, const Points& to) {
  const Linearised system = linear(from, to);
  const Eigen::ColPivHouseholderQR<Equations> qr(system.J);
  const auto pivots = qr.matrixR().diagonal().head<8>().cwiseAbs().eval();
  if (!(pivots.minCoeff() > flattest * pivots.maxCoeff())) {
    throw std::invalid_argument(
        "pixels and positions must not have all points but one on a line, or fewer than four "
        "different points");
  }
  return qr.solve(system.r);
}

Homography matrix_of(const Parameters& h) {
  Homography matrix;
  matrix << h(0), h(1), h(2), h(3), h(4), h(5), h(6), h(7), 1;
  return matrix;
}

void check_fit(const Parameters& h, const Points& from, const Points& to) {
  const Eigen::Vector2d w = h.tail<2>();
  const bool is_in_front = ((w.transpose() * from).array() > -1).all();
  const double worst = worst_fit * worst_fit * to.squaredNorm();
  const bool is_near = around(h, from, to).r.squaredNorm() <= worst;
  if (is_in_front && is_near && matrix_of(h).determinant() > 0) return;
  throw std::invalid_argument(
      "pixels and positions must have the points in the same order: the first pixel belongs to the "
      "first position; no camera sees them in this order");
}

}  // namespace

PlaneMap::Matrix fit_homography(const std::vector<Point>& pixels,
                                const std::vector<Point>& positions) {
  const Normalised from(pixels);
  const Normalised to(positions);
  Parameters h = start(from.points, to.points);
  for (int i = 0; i < most_iterations; ++i) {
    const Linearised system = around(h, from.points, to.points);
    const Parameters step = system.J.colPivHouseholderQr().solve(system.r);
    h += step;
    if (!(step.norm() > converged * h.norm())) break;
  }
  check_fit(h, from.points, to.points);
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> matrix =
      to.to_normalised.inverse() * matrix_of(h) * from.to_normalised;
  PlaneMap::Matrix result;
  std::copy_n(matrix.data(), 9, result.begin());
  return result;
}

}  // namespace robsim
