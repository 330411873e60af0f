#include "robsim/imaging/plane_map.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "robsim/base/system.hpp"

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

Matrix product(const Matrix& a, const Matrix& b) {
  Matrix result{};
  for (std::size_t row = 0; row < 9; row += 3) {
    for (std::size_t column = 0; column < 3; ++column) {
      for (std::size_t i = 0; i < 3; ++i) result[row + column] += a[row + i] * b[3 * i + column];
    }
  }
  return result;
}

// For each three of the first four points +1 if they turn right, -1 if left.
std::array<int, 4> turns(const char* name, const std::vector<Point>& points) {
  constexpr std::array<std::array<std::size_t, 3>, 4> triples = {
      {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}}};
  constexpr double flattest = 1e-3;  // area of a triangle as a fraction of the largest one's
  std::array<double, 4> areas;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto [a, b, c] = triples[i];
    areas[i] = (points[b].x - points[a].x) * (points[c].y - points[a].y) -
               (points[c].x - points[a].x) * (points[b].y - points[a].y);
  }
  const auto by_size = [](double a, double b) { return std::abs(a) < std::abs(b); };
  const auto [smallest, largest] = std::minmax_element(areas.begin(), areas.end(), by_size);
  if (std::abs(*smallest) <= flattest * std::abs(*largest)) {
    throw std::invalid_argument(std::string(name) + " must not have three points on a line");
  }
  std::array<int, 4> signs;
  std::transform(areas.begin(), areas.end(), signs.begin(),
                 [](double a) { return a > 0 ? 1 : -1; });
  return signs;
}

// The homography that takes (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1) to four points: its columns
// are the first three points, each times the number that makes their sum the fourth.
Matrix from_unit_points(const std::vector<Point>& p) {
  const Matrix columns = {p[0].x, p[1].x, p[2].x, p[0].y, p[1].y, p[2].y, 1, 1, 1};
  const Matrix m = inverse(columns);
  Matrix scaled = columns;
  for (std::size_t i = 0; i < 3; ++i) {
    const double factor = m[3 * i] * p[3].x + m[3 * i + 1] * p[3].y + m[3 * i + 2];
    for (std::size_t row = 0; row < 9; row += 3) scaled[row + i] *= factor;
  }
  return scaled;
}

Point projected(const Matrix& m, const Point& p) {
  const double w = m[6] * p.x + m[7] * p.y + m[8];
  return {(m[0] * p.x + m[1] * p.y + m[2]) / w, (m[3] * p.x + m[4] * p.y + m[5]) / w};
}

std::vector<Point> ideal_pixels(std::vector<Point> pixels,
                                const std::optional<Intrinsics>& intrinsics) {
  if (!intrinsics) return pixels;
  for (Point& pixel : pixels) {
    const Point ideal = intrinsics->ideal(pixel);
    if (std::isnan(ideal.x)) {
      throw std::invalid_argument("pixels must lie where the lens shows something, got (" +
                                  to_text(pixel.x) + ", " + to_text(pixel.y) + ")");
    }
    pixel = ideal;
  }
  return pixels;
}

}  // namespace

PlaneMap::PlaneMap() : PlaneMap(Matrix{1, 0, 0, 0, 1, 0, 0, 0, 1}) {}

PlaneMap::PlaneMap(const Matrix& to_world, const std::optional<Intrinsics>& intrinsics)
    : to_world_(normalised(to_world)),
      to_pixel_(inverse(to_world_)),
      intrinsics_(intrinsics ? std::make_shared<Intrinsics>(*intrinsics) : nullptr) {}

PlaneMap PlaneMap::scaled(int width, int height, double area_width, double area_height,
                          Point origin) {
  // x = (u + 1/2) W/w - 1/2, y = (v + 1/2) H/h - 1/2
  const double sx = area_width / width;
  const double sy = area_height / height;
  return PlaneMap(Matrix{sx, 0, sx / 2 - 0.5 + origin.x, 0, sy, sy / 2 - 0.5 + origin.y, 0, 0, 1});
}

PlaneMap PlaneMap::from_points(const std::vector<Point>& pixels,
                               const std::vector<Point>& positions,
                               const std::optional<Intrinsics>& intrinsics) {
  if (pixels.size() != positions.size() || pixels.size() < 4) {
    throw std::invalid_argument(
        "pixels and positions must have as many points, at least four, got " +
        std::to_string(pixels.size()) + " and " + std::to_string(positions.size()));
  }
  const std::vector<Point> ideal = ideal_pixels(pixels, intrinsics);
  if (ideal.size() > 4) return PlaneMap(fit_homography(ideal, positions), intrinsics);
  if (turns("pixels", ideal) != turns("positions", positions)) {
    throw std::invalid_argument(
        "pixels and positions must have the four points in the same order: the first pixel belongs "
        "to the first position; these go round in another order");
  }
  return PlaneMap(product(from_unit_points(positions), inverse(from_unit_points(ideal))),
                  intrinsics);
}

PlaneMap PlaneMap::at_height(double height) const {
  if (!intrinsics_) {
    throw std::invalid_argument(
        "height needs the camera's intrinsics: without them the map knows of the floor alone");
  }
  if (!std::isfinite(height)) throw std::invalid_argument("height must be finite (work-area px)");
  const auto& [fx, fy] = intrinsics_->focal();
  const auto& [cx, cy] = intrinsics_->centre();
  const Matrix& h = to_pixel_;
  // K^-1 H, its columns s r1, s r2, s t
  Matrix m;
  for (std::size_t i = 0; i < 3; ++i) {
    m[i] = (h[i] - cx * h[6 + i]) / fx;
    m[3 + i] = (h[3 + i] - cy * h[6 + i]) / fy;
    m[6 + i] = h[6 + i];
  }
  const auto length = [&](std::size_t i) {
    return std::sqrt(m[i] * m[i] + m[3 + i] * m[3 + i] + m[6 + i] * m[6 + i]);
  };
  // |s| by r1 and r2, which have the length 1; what the camera looks at is in front of it.
  const double front = to_world_[6] * cx + to_world_[7] * cy + to_world_[8] < 0 ? -1 : 1;
  const double s = front * (length(0) + length(1)) / 2;
  for (double& value : m) value /= s;
  const std::array<double, 3> r3 = {m[3] * m[7] - m[6] * m[4], m[6] * m[1] - m[0] * m[7],
                                    m[0] * m[4] - m[3] * m[1]};
  // The camera's place on the floor's normal r3, which is to point to its side.
  const double place = -(r3[0] * m[2] + r3[1] * m[5] + r3[2] * m[8]);
  if (!(height < std::abs(place))) {
    throw std::invalid_argument("height must be below the camera, which is " +
                                to_text(std::abs(place)) + " work-area px above the floor, got " +
                                to_text(height));
  }
  const double up = place > 0 ? height : -height;
  for (std::size_t i = 0; i < 3; ++i) m[3 * i + 2] += up * r3[i];
  const Matrix camera = {fx, 0, cx, 0, fy, cy, 0, 0, 1};
  return PlaneMap(inverse(product(camera, m)), *intrinsics_);
}

Point PlaneMap::to_world(const Point& pixel) const { return projected(to_world_, ideal(pixel)); }

Point PlaneMap::to_pixel(const Point& position) const {
  const Point seen = projected(to_pixel_, position);
  return intrinsics_ ? intrinsics_->distorted(seen) : seen;
}

double PlaneMap::area_scale(const Point& pixel) const {
  const Point seen = ideal(pixel);
  // The Jacobian of a homography M at p has the determinant det M / w^3, w = (M p)_3.
  const double w = to_world_[6] * seen.x + to_world_[7] * seen.y + to_world_[8];
  const double scale = std::abs(determinant(to_world_) / (w * w * w));
  if (!intrinsics_) return scale;
  const auto [a, b, c, d] = intrinsics_->ideal_derivatives(seen);
  return scale * (a * d - b * c);
}

}  // namespace robsim
