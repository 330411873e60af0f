#pragma once

#include <mutex>
#include <string>
#include <vector>

#include "robsim/base/geometry.hpp"

namespace robsim {

/// The outline of a marker in the robot's frame (work-area px), and how far places are from it.
class MarkerShape {
 public:
  /// Throws std::invalid_argument, naming `name`, for what is no polygon.
  MarkerShape(Polygon polygon, const std::string& name);

  const Polygon& polygon() const { return polygon_; }
  Point centroid() const { return centroid_; }
  double perimeter() const { return perimeter_; }

  /// Signed distances from the outline on a grid of cells around the marker, as far outside as it
  /// is wide; above 0 inside.
  class Table {
   public:
    explicit Table(const Polygon& polygon);

    static constexpr int cells = 128;  // in each direction

    /// The distance in the middle of a cell (work-area px), and its gradient.
    struct Cell {
      float distance, slope_x, slope_y, unused;
    };
    const Cell* data() const { return cells_.data(); }  // row by row

    double left() const { return left_; }  // work-area px
    double top() const { return top_; }
    double per_px() const { return per_px_; }  // cells

   private:
    double left_, top_;
    double per_px_;
    std::vector<Cell> cells_;
  };

  /// Made when first asked for; from any thread.
  const Table& table() const;

 private:
  Polygon polygon_;
  Point centroid_;
  double perimeter_ = 0;
  mutable std::once_flag once_;
  mutable std::vector<Table> table_;  // one, or none yet
};

}  // namespace robsim
