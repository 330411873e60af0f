#include "robsim/vision/fit/pose_fit.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "robsim/base/elementary/elementary.hpp"
#include "robsim/vision/fit/edge_fit.hpp"
#include "robsim/vision/fit/hidden_edge.hpp"
#include "robsim/vision/fit/light_step.hpp"

namespace robsim {

void add_doubt(const Pose& pose, const Pose& other, double share, PoseCovariance& covariance,
               double& misfit) {
  const Eigen::Vector3d shift(other.x - pose.x, other.y - pose.y,
                              wrap_angle(other.heading - pose.heading));
  const Eigen::Array3d before = covariance.diagonal();
  covariance += share * shift * shift.transpose();
  misfit *= (covariance.diagonal().array() / before).maxCoeff();
}

namespace {

using namespace fit;

constexpr int unknowns = 6;  // x, y, heading, ln blur, share by which markers are apart, growth
using Information = Eigen::Matrix<double, unknowns, unknowns>;
using Step = Eigen::Matrix<double, unknowns, 1>;

constexpr double usual_blur = 0.62;  // frame px: a sharp picture
constexpr double sharp = 1.4;        // frame px; what is more blurred needs a wider ring

// What is known before, as standard deviations.
constexpr double blur_spread = 0.3;    // of its logarithm
constexpr double apart_spread = 0.05;  // of the distance between the markers
constexpr double growth_spread = 0.5;  // frame px

constexpr int most_fit_steps = 4;
constexpr int most_robust_steps = 8;
constexpr int most_blur_steps = 10;
constexpr double blur_found = 0.1;        // change of the logarithm of the blur in a step
constexpr double longest_step = 1.5;      // frame px
constexpr double still = 0.005;           // a step that is the last one
constexpr double negligible = 0.4;        // the same, in standard deviations of the unknowns
constexpr double converged_step = 0.1;    // a step that may be the last one
constexpr double gather_again = 0.8;      // moves of which the distances are out of date
constexpr double mostly_explained = 0.3;  // of the misfit, what a step of light may leave
constexpr int least_part = 30;            // pixels of a marker in a light of their own
constexpr double suspicious = 1.5;        // misfit above which steps of light are looked for
constexpr double correlated = 2;          // misfit above which pixels are weighed
constexpr double visible = 0.05;          // residuals above which it pays: share of the contrast
constexpr double clearly_better = 0.8;    // ratio of residuals with weights to those without
constexpr double picture_error = 0.008;   // frame px a marker: pictures are not drawn more exactly

// Measured on squares without blur, in frames of 480 and 1200 px (frame px).
constexpr double grid_error = 0.12;
constexpr double sharp_blur = 0.46, no_blur = 0.56;  // where it is that, and 0
constexpr double least_alike = 3;                    // how much of a side must be alike
constexpr double strong_noise = 0.12;  // share of the contrast: it hides the blur, and this error

// A hidden edge, and how sure it must be, in squared standard deviations.
constexpr double edge_error = 0.02;      // frame px: pictures of an edge are not more exact
constexpr double usual_share = 0.17;     // of all squares of a marker, those of such an edge
constexpr double least_share = 0.08;     // the same: no mere corner
constexpr double first_evidence = 6;     // if all else were known
constexpr double certain_evidence = 20;  // chance gives more in 1 of 10 000 frames

// The robot's pose if the edge is hidden.
struct HiddenEdge {
  std::size_t marker, direction;
  double evidence;
  Pose pose;
};

struct Unknowns {
  Pose pose;
  double log_blur = 0;  // from the usual one
  double apart = 0;
  double growth = 0;  // work-area px

  double blur() const { return usual_blur * elementary::exp(log_blur); }
};

class Fit {
 public:
  Fit(const ImageView& image, const PlaneMap& map, const MarkerShape& first,
      const MarkerShape& second, const Pose& start)
      : image_(image), map_(map), shapes_{&first, &second} {
    at_.pose = start_ = start;
    const Point a = first.centroid(), b = second.centroid();
    const Point middle{(a.x + b.x) / 2, (a.y + b.y) / 2};
    from_middle_[0] = {a.x - middle.x, a.y - middle.y};
    from_middle_[1] = {b.x - middle.x, b.y - middle.y};
  }

  std::optional<PoseFit> run() {
    if (!gather_edges() || !iterate(most_fit_steps)) return std::nullopt;
    const double factor = misfit();
    if (find_light_steps(factor > suspicious)) {
      Fit in_two_lights = *this;
      in_two_lights.divide_by_light();
      if (in_two_lights.iterate(most_robust_steps)) {
        const double left = in_two_lights.misfit();
        if (left - 1 <= mostly_explained * (factor - 1)) {
          auto fit = in_two_lights.result_without_hidden_pixels(left);
          if (fit) doubt(*fit, factor);
          return fit;
        }
      }
      light_steps_ = {};
    }
    return result_without_hidden_pixels(factor);
  }

 private:
  // Of a marker that is partly hidden, the rest fits much better without that part.
  std::optional<PoseFit> result_without_hidden_pixels(double factor) {
    if (factor <= correlated || largest_residual() <= visible) return result(factor);
    const Fit plain = *this;
    is_robust_ = true;
    if (!iterate(most_robust_steps) || !fits_better_than(plain)) return plain.result(factor);
    return result(std::max(factor, misfit()));
  }

  double scale() const { return (parts_.front().pixels.scale + parts_.back().pixels.scale) / 2; }

  double misfit() const { return variance_factor(parts_); }

  // (contrast to noise)^2 of the marker where it is less, each in its best light.
  double least_precision() const {
    double best[2] = {0, 0};
    for (const EdgeFit& part : parts_) {
      best[part.marker] = std::max(best[part.marker], part.precision());
    }
    return std::min(best[0], best[1]);
  }

  // The standard deviation of the residuals, as a share of the contrast.
  double largest_residual() const { return 1 / std::sqrt(least_precision()); }

  bool fits_better_than(const Fit& other) const {
    if (parts_.size() != other.parts_.size()) return false;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const double usual = other.parts_[i].usual_residual();
      if (parts_[i].usual_residual() < clearly_better * usual) return true;
    }
    return false;
  }

  bool find_light_steps(bool is_suspicious) {
    for (const EdgeFit& part : parts_) {
      if (is_suspicious || has_light_slope(part)) light_steps_[part.marker] = find_light_step(part);
    }
    return light_steps_[0] || light_steps_[1];
  }

  bool gather_edges() {
    gathered_ = at_.pose;
    // A blurred edge is as wide as its blur.
    const double wider = 1.5 * std::max(0.0, at_.blur() - 0.8);
    const Ring ring{Ring{}.outside + wider, Ring{}.inside + wider};
    parts_.resize(2);
    for (std::size_t k = 0; k < 2; ++k) {
      parts_[k].marker = k;
      gather(image_, map_, *shapes_[k], gathered_, ring, parts_[k].pixels);
      if (parts_[k].pixels.count == 0) return false;
    }
    if (without_) leave_out(without_->direction, parts_[without_->marker].pixels);
    divide_by_light();
    return true;
  }

  void divide_by_light() {
    for (std::size_t k = 0; k < 2; ++k) {
      if (light_steps_[k]) divide(k, *light_steps_[k]);
    }
  }

  // Puts the pixels of marker k beyond a step of light into a part of their own.
  void divide(std::size_t k, const LightStep& step) {
    auto [near, beyond] = divided(parts_[k].pixels, step);
    if (near.count < least_part) std::swap(near, beyond);
    if (near.count < least_part) return;
    parts_[k].pixels = std::move(near);
    if (beyond.count < least_part) return;
    EdgeFit part;
    part.marker = k;
    part.pixels = std::move(beyond);
    parts_.push_back(std::move(part));
  }

  // False if the edge of a marker is in none of its parts.
  bool update_parts() {
    bool has_edge[2] = {false, false};
    for (EdgeFit& part : parts_) {
      if (part.update(shift_of(part.marker))) has_edge[part.marker] = true;
    }
    if (!has_edge[0] || !has_edge[1]) return false;
    const auto tells_nothing = [](const EdgeFit& part) { return part.weights.gain == 0; };
    parts_.erase(std::remove_if(parts_.begin(), parts_.end(), tells_nothing), parts_.end());
    return true;
  }

  // How marker k has moved since its pixels were gathered.
  EdgeShift shift_of(std::size_t k) const {
    const auto [sin, cos] = elementary::sin_cos(gathered_.heading);
    const double x = at_.pose.x - gathered_.x;
    const double y = at_.pose.y - gathered_.y;
    EdgeShift shift;
    shift.x = x * cos + y * sin + at_.apart * from_middle_[k].x;
    shift.y = -x * sin + y * cos + at_.apart * from_middle_[k].y;
    shift.turn = wrap_angle(at_.pose.heading - gathered_.heading);
    shift.grow = at_.growth;
    shift.blur = at_.blur();
    return shift;
  }

  // From the unknowns to the parameters of the edge of a part.
  Eigen::Matrix<double, parameters, unknowns> jacobian(const EdgeFit& part) const {
    const Point& from_middle = from_middle_[part.marker];
    const auto [sin, cos] = elementary::sin_cos(gathered_.heading);
    Eigen::Matrix<double, parameters, unknowns> j;
    j << -cos, -sin, 0, 0, -from_middle.x, 0,  //
        sin, -cos, 0, 0, -from_middle.y, 0,    //
        0, 0, 1, 0, 0, 0,                      //
        0, 0, 0, 0, 0, 1,                      //
        0, 0, 0, 0, 0, 0;
    j *= part.pixels.scale / at_.blur();
    j(4, 3) = -1;  // dq / d ln blur = -q
    return j;
  }

  // The normal equations where the fit is: information N and gradient g. False without an edge.
  bool linearize() {
    const double growth = growth_spread / scale();
    Step precision;
    precision << 0, 0, 0, 1 / (blur_spread * blur_spread), 1 / (apart_spread * apart_spread),
        1 / (growth * growth);
    Step deviation;
    deviation << 0, 0, 0, at_.log_blur, at_.apart, at_.growth;
    information_ = precision.asDiagonal();
    gradient_ = -precision.cwiseProduct(deviation);
    signal_ = 0;
    if (!update_parts()) return false;
    for (const EdgeFit& part : parts_) {
      const Eigen::Matrix<double, parameters, unknowns> j = jacobian(part);
      const Eigen::Map<const Eigen::Matrix<double, parameters, parameters, Eigen::RowMajor>> sums(
          part.sums.information[0].data());
      const Eigen::Map<const Eigen::Matrix<double, parameters, 1>> residuals(
          part.sums.gradient.data());
      // N = sum_k gain^2/v J'D'PD J,  g = sum_k gain/v J'D'P z
      information_ += part.precision() * (j.transpose() * sums * j);
      gradient_ += part.weights.gain / part.variance * (j.transpose() * residuals);
      signal_ += part.precision() * part.sums.slope;
    }
    return true;
  }

  bool iterate(int steps) {
    bool is_blur_found = false;
    for (int i = 0; i < steps || (!is_blur_found && i < most_blur_steps); ++i) {
      if (i > 0 && is_out_of_date() && !gather_edges()) return false;
      if (is_robust_ && !weigh_pixels()) return false;
      if (!linearize()) return false;
      const Eigen::LLT<Information> decomposition(information_);
      if (decomposition.info() != Eigen::Success) return false;
      Step step = decomposition.solve(gradient_);
      const double length = scale() * displacement(step[0], step[1], step[2]);  // frame px
      if (!std::isfinite(length)) return false;
      // The step in standard deviations: s^2 = g' N^-1 g
      const bool is_negligible = gradient_.dot(step) < negligible * negligible;
      has_converged_ = length < converged_step || is_negligible;
      if (length > longest_step) step *= longest_step / length;
      take(step);
      is_blur_found = std::fabs(step[3]) < blur_found;
      if ((length < still || is_negligible) && is_blur_found) break;
    }
    return true;
  }

  bool weigh_pixels() {
    if (!update_parts()) return false;
    for (EdgeFit& part : parts_) part.weigh_by_residual();
    return true;
  }

  // How far the marker that moves further does so (work-area px).
  double displacement(double x, double y, double turn) const {
    const auto [sin, cos] = elementary::sin_cos(at_.pose.heading);
    double largest = 0;
    for (const MarkerShape* shape : shapes_) {
      const Point& at = shape->centroid();
      const double dx = x - turn * (at.x * sin + at.y * cos);
      const double dy = y + turn * (at.x * cos - at.y * sin);
      largest = std::max(largest, elementary::hypot(dx, dy));
    }
    return largest;
  }

  double moved_from(const Pose& pose) const {  // frame px
    return scale() * displacement(at_.pose.x - pose.x, at_.pose.y - pose.y,
                                  wrap_angle(at_.pose.heading - pose.heading));
  }

  void take(const Step& step) {
    at_.pose.x += step[0];
    at_.pose.y += step[1];
    at_.pose.heading = wrap_angle(at_.pose.heading + step[2]);
    at_.log_blur = std::clamp(at_.log_blur + step[3], -1.0, 2.5);
    at_.apart += step[4];
    at_.growth += step[5];
  }

  bool is_out_of_date() {
    const bool is_wide = at_.blur() > sharp;
    return is_wide || moved_from(gathered_) > gather_again;
  }

  std::optional<PoseFit> result(double factor) const {
    PoseFit fit;
    fit.pose = at_.pose;
    fit.misfit = fit.remainder = factor;
    fit.has_converged = has_converged_;
    fit.moved = moved_from(start_);
    // The integral of phi(q)^2 of a normal edge, 1/(2 sqrt(pi)), over that of T'^2.
    constexpr double normal_share = 0.731;
    fit.signal_to_noise = std::sqrt(normal_share * signal_);
    const Information all = information_.inverse();
    // The estimate of weak edges is not linear in the noise: measured on simulated pictures.
    const double second_order = 1.05 + 15 / (fit.signal_to_noise * fit.signal_to_noise);
    fit.covariance = factor * second_order * all.topLeftCorner<3, 3>() + picture_covariance(factor);
    if (!fit.covariance.allFinite()) return std::nullopt;
    spread(hidden_edges(factor), fit);
    return fit;
  }

  // Method: score tests (Rao, 1948) of edges that are moved inwards.
  std::vector<HiddenEdge> hidden_edges(double factor) const {
    std::vector<HiddenEdge> found;
    for (std::size_t marker = 0; marker < 2; ++marker) {
      std::array<double, hidden_directions> scores{};
      double squares = 0;  // of all edges
      for (const EdgeFit& part : parts_) {
        if (part.marker != marker) continue;
        const auto of_part = scores_of_hidden_edges(part);
        // dq = -size/blur
        for (std::size_t k = 0; k < hidden_directions; ++k)
          scores[k] -= part.weights.gain / part.variance * of_part[k] / at_.blur();
        squares += part.precision() * part.sums.slope / (at_.blur() * at_.blur());
      }
      const double usual = usual_share * squares;
      const double noise = usual * (factor + edge_error * edge_error * usual);
      for (std::size_t k = 0; k < hidden_directions; ++k) {
        if (scores[k] < 0 || scores[k] * scores[k] < first_evidence * noise) continue;
        const HiddenEdge edge = hidden_edge(marker, k, scores[k], least_share * squares, factor);
        if (edge.evidence > certain_evidence) found.push_back(edge);
      }
    }
    return found;
  }

  HiddenEdge hidden_edge(std::size_t marker, std::size_t direction, double score, double least,
                         double factor) const {
    double squares = 0, all = 0;
    Step cross = Step::Zero();
    for (const EdgeFit& part : parts_) {
      if (part.marker != marker) continue;
      const HiddenEdgeSums sums = sums_of_hidden_edge(part, direction);
      const Eigen::Map<const Eigen::Matrix<double, parameters, 1>> of_part(sums.cross.data());
      const double precision = part.precision() / at_.blur();
      squares += precision * sums.squares / at_.blur();
      all += precision * sums.information / at_.blur();
      cross -= precision * (jacobian(part).transpose() * of_part);
    }
    // size = h'Pz / h'Ph,  P the projection off all unknowns
    const Step along = information_.llt().solve(cross);
    const double information = all - cross.dot(along);
    const double size = (score - along.dot(gradient_)) / information;
    const double variance = factor / information + edge_error * edge_error;
    const bool is_edge = size > 0 && squares > least;
    return {marker,
            direction,
            is_edge ? size * size / variance : 0,
            {at_.pose.x - size * along[0], at_.pose.y - size * along[1],
             at_.pose.heading - size * along[2]}};
  }

  // All possible poses take part in the covariance, by their evidence.
  static void spread(const std::vector<HiddenEdge>& edges, PoseFit& fit) {
    double most = -std::numeric_limits<double>::infinity(), all = 0;
    for (const HiddenEdge& edge : edges) most = std::max(most, edge.evidence);
    for (const HiddenEdge& edge : edges) all += elementary::exp((edge.evidence - most) / 2);
    for (const HiddenEdge& edge : edges) {
      const double share = elementary::exp((edge.evidence - most) / 2) / all;
      add_doubt(fit.pose, edge.pose, share, fit.covariance, fit.misfit);
    }
  }

  // A step of light may be at a hidden edge, or at another one that this moves from its place. Fits
  // without one edge each decide.
  void doubt(PoseFit& fit, double factor) {
    light_steps_ = {};
    std::vector<HiddenEdge> ways;
    for (HiddenEdge edge : hidden_edges(factor)) {
      Fit way = *this;
      way.without_ = edge;
      if (!way.gather_edges() || !way.iterate(most_robust_steps)) continue;
      // An eighth of the pixels count: neighbours are alike, and strips hide ends of other sides.
      edge.evidence =
          parts_[edge.marker].pixels.count / 8.0 * elementary::log(way.least_precision());
      edge.pose = way.at_.pose;
      ways.push_back(edge);
    }
    spread(ways, fit);
  }

  // Of places of the markers that are each as wrong as pictures are drawn, or as what the fit
  // leaves beside noise would move an edge of this blur.
  PoseCovariance picture_covariance(double factor) const {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    const auto [sin, cos] = elementary::sin_cos(at_.pose.heading);
    for (const MarkerShape* shape : shapes_) {
      const Point at = shape->centroid();
      // d(X, Y)/d(x, y, heading) of a marker at (X, Y) from the centre
      Eigen::Matrix<double, 2, 3> j;
      j << 1, 0, -(at.x * sin + at.y * cos), 0, 1, at.x * cos - at.y * sin;
      sum += j.transpose() * j;
    }
    const double left = (1 - 1 / factor) / least_precision();
    const double variance =
        picture_error * picture_error + left * at_.blur() * at_.blur() + grid_variance();
    return variance / (scale() * scale()) * sum.inverse();
  }

  // Of the place of a marker (frame px^2) whose sides lie along rows or columns in a picture
  // without blur: all pixels of such a side are wrong alike, as the model's step is no ramp of a
  // pixel.
  double grid_variance() const {
    const double sharpness = std::min((no_blur - at_.blur()) / (no_blur - sharp_blur), 1.0);
    if (sharpness <= 0 || largest_residual() > strong_noise) return 0;
    const auto [sin, cos] = elementary::sin_cos(at_.pose.heading);
    double most = 0;
    for (const MarkerShape* shape : shapes_) {
      Polygon seen;
      for (const Point& at : shape->polygon())
        seen.push_back(map_.to_pixel(
            {at_.pose.x + at.x * cos - at.y * sin, at_.pose.y + at.x * sin + at.y * cos}));
      double squares = 0, all = 0;
      for (std::size_t i = 0; i < seen.size(); ++i) {
        const Point& to = seen[(i + 1) % seen.size()];
        const double across = std::fabs(to.x - seen[i].x), down = std::fabs(to.y - seen[i].y);
        const double length = elementary::hypot(across, down);
        const double alike = length / std::max(1.0, pi * std::min(across, down));
        if (alike > least_alike) squares += alike * alike;
        all += length;
      }
      // place = 2 sum n error length / all, half of whose variance is in x, half in y
      most = std::max(most, 2 * squares / (all * all));
    }
    return most * (grid_error * sharpness) * (grid_error * sharpness);
  }

  const ImageView& image_;
  const PlaneMap& map_;
  const MarkerShape* shapes_[2];
  Point from_middle_[2];        // work-area px, in the robot's frame
  std::vector<EdgeFit> parts_;  // one of each marker in each light
  std::array<std::optional<LightStep>, 2> light_steps_;
  Pose start_;
  Pose gathered_;
  Unknowns at_;
  bool is_robust_ = false;
  std::optional<HiddenEdge> without_;  // the edge whose pixels are left out
  Information information_;
  Step gradient_;
  double signal_ = 0;
  bool has_converged_ = false;
};

}  // namespace

std::optional<PoseFit> fit_pose(const ImageView& image, const PlaneMap& map,
                                const MarkerShape& first, const MarkerShape& second,
                                const Pose& start) {
  return Fit(image, map, first, second, start).run();
}

}  // namespace robsim
