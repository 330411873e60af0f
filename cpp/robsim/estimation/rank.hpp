#pragma once

namespace robsim {

/// What full rank is, for all estimates from regressors. Their columns are scaled to length 1;
/// singular values up to this fraction of the largest are rounding errors. An unknown is not
/// determined if more than this fraction of the square of its direction belongs to these.
constexpr double rank_tolerance = 1e-10;

}  // namespace robsim
