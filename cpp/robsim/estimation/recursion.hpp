#pragma once

#include <cstddef>

namespace robsim {

/// s(k) = a1 s(k-1) + a2 s(k-2) + force(k), column by column of row-major arrays; s is 0 before the
/// first row.
void second_order_recursion(double a1, double a2, const double* force, double* s, std::size_t rows,
                            std::size_t columns);

}  // namespace robsim
