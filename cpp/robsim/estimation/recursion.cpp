#include "robsim/estimation/recursion.hpp"

#include <vector>

namespace robsim {

void second_order_recursion(double a1, double a2, const double* force, double* s, std::size_t rows,
                            std::size_t columns) {
  const std::vector<double> before(columns, 0.0);
  const double* last = before.data();
  const double* last_but_one = before.data();
  for (std::size_t k = 0; k < rows; ++k) {
    for (std::size_t i = 0; i < columns; ++i) {
      s[i] = a1 * last[i] + a2 * last_but_one[i] + force[i];
    }
    last_but_one = last;
    last = s;
    s += columns;
    force += columns;
  }
}

}  // namespace robsim
