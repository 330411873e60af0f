#pragma once

#include <array>

#include "robsim/vision/fit/edge_fit.hpp"

namespace robsim::fit {

/// Directions of the normals, in the robot's frame, in which a marker may be hidden.
constexpr int hidden_directions = 16;

/// A unit vector.
struct Direction {
  double x = 1, y = 0;
};
const std::array<Direction, hidden_directions>& directions_of_hidden_edges();

/// How much of a pixel's edge is moved where an edge with normals like `direction` is hidden.
double hidden_share(const Direction& direction, double normal_x, double normal_y);

/// Sums for an edge inside of the outline, where the normals are like a direction. H: how the
/// coverages change by q there.
struct HiddenEdgeSums {
  double score = 0;                        // H'z
  double squares = 0;                      // H'H
  double information = 0;                  // H'PH
  std::array<double, parameters> cross{};  // D'PH, without the blur
};

/// The pixels of a part, by the direction of their normals. The fit must have been updated, and be
/// there as long.
class EdgeSectors {
 public:
  explicit EdgeSectors(const EdgeFit& part);

  /// Score and squares alone, which take little time.
  HiddenEdgeSums first_look(std::size_t direction) const;
  HiddenEdgeSums sums(std::size_t direction) const;

 private:
  struct Sums {
    float residual = 0, slope = 0, slope_coverage = 0;  // T'z, T', T'T
    float products[4] = {0, 0, 0, 0};                   // T'D; the last is T'^2
  };
  const EdgeFit& part_;
  std::array<Sums, 32> sectors_;
};

}  // namespace robsim::fit
