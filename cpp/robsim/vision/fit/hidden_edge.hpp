#pragma once

#include <array>
#include <cstddef>

#include "robsim/vision/fit/edge_fit.hpp"

namespace robsim::fit {

// A strip in the colour of the body may hide an edge of a marker: an edge inside of the outline
// takes its place, where the normals are like one of these directions in the robot's frame. H: how
// the coverages change by q there.
constexpr std::size_t hidden_directions = 8;

/// H'z, for all directions. The fit must have been updated.
std::array<double, hidden_directions> scores_of_hidden_edges(const EdgeFit& part);

struct HiddenEdgeSums {
  double squares;                          // H'H
  double information;                      // H'PH
  std::array<double, parameters> cross{};  // D'PH, without the blur
};
HiddenEdgeSums sums_of_hidden_edge(const EdgeFit& part, std::size_t direction);

/// Takes the pixels at that edge their weight.
void leave_out(std::size_t direction, EdgePixels& pixels);

}  // namespace robsim::fit
