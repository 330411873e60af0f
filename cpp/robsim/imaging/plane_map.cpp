#include "robsim/imaging/plane_map.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace robsim {

namespace {

using Matrix = PlaneMap::Matrix;

double determinant(const Matrix& m) {
  return m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) +
         m[2] * (m[3] * m[7] - m[4] * m[6]);
}

// A homography is the same times any number: its last entry, or its largest one, becomes 1.
Matrix normalised(Matrix m) {
  double scale = m[8];
  if (scale == 0) {
    for (const double value : m) scale = std::max(scale, std::abs(value));
  }
  for (double& value : m) value /= scale;
  return m;
}

Matrix inverse(const Matrix& m) {
  const double det = determinant(m);
  if (!std::isfinite(det) || std::abs(det) < 1e-15) {
    throw std::invalid_argument("matrix must be a finite 3 x 3 homography with an inverse");
  }
  const Matrix adjugate = {
      m[4] * m[8] - m[5] * m[7], m[2] * m[7] - m[1] * m[8], m[1] * m[5] - m[2] * m[4],
      m[5] * m[6] - m[3] * m[8], m[0] * m[8] - m[2] * m[6], m[2] * m[3] - m[0] * m[5],
      m[3] * m[7] - m[4] * m[6], m[1] * m[6] - m[0] * m[7], m[0] * m[4] - m[1] * m[3]};
  Matrix result;
  for (std::size_t i = 0; i < 9; ++i) result[i] = adjugate[i] / det;
  return result;
}

Point apply(const Matrix& m, const Point& p) {
  const double w = m[6] * p.x + m[7] * p.y + m[8];
  return {(m[0] * p.x + m[1] * p.y + m[2]) / w, (m[3] * p.x + m[4] * p.y + m[5]) / w};
}

}  // namespace

PlaneMap::PlaneMap() : PlaneMap(Matrix{1, 0, 0, 0, 1, 0, 0, 0, 1}) {}

PlaneMap::PlaneMap(const Matrix& to_world)
    : to_world_(normalised(to_world)), to_pixel_(inverse(to_world_)) {}

PlaneMap PlaneMap::scaled(int width, int height, double area_width, double area_height,
                          Point origin) {
  // x = (u + 1/2) W/w - 1/2, y = (v + 1/2) H/h - 1/2
  const double sx = area_width / width;
  const double sy = area_height / height;
  return PlaneMap(Matrix{sx, 0, sx / 2 - 0.5 + origin.x, 0, sy, sy / 2 - 0.5 + origin.y, 0, 0, 1});
}

Point PlaneMap::to_world(const Point& pixel) const { return apply(to_world_, pixel); }

Point PlaneMap::to_pixel(const Point& place) const { return apply(to_pixel_, place); }

double PlaneMap::area_scale(const Point& pixel) const {
  // The Jacobian of a homography M at p has the determinant det M / w^3, w = (M p)_3.
  const double w = to_world_[6] * pixel.x + to_world_[7] * pixel.y + to_world_[8];
  return std::abs(determinant(to_world_) / (w * w * w));
}

}  // namespace robsim
