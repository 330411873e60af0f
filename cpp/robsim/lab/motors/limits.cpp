#include "robsim/lab/motors/limits.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "robsim/base/system.hpp"

namespace robsim {

namespace {

void check_limit(const char* name, double limit, const char* unit) {
  if (!(limit > 0)) {
    throw std::invalid_argument(std::string(name) + " must be above 0 " + unit + ", got " +
                                to_text(limit));
  }
}

double larger(const Input& u) { return std::max(std::abs(u.u1), std::abs(u.u2)); }

Input scaled(const Input& u, double limit) {
  if (larger(u) <= limit) return u;
  const double factor = limit / larger(u);
  // Rounding may lead out by the last digit.
  return {std::clamp(u.u1 * factor, -limit, limit), std::clamp(u.u2 * factor, -limit, limit)};
}

}  // namespace

void Limits::check() const {
  check_limit("voltage", voltage, "V");
  check_limit("slew_rate", slew_rate, "V/s");
}

Input Limits::applied(const Input& u, const Input& before, double dt) const {
  if (u.u1 == 0 && u.u2 == 0) return u;
  const Input wanted = scaled(u, voltage);
  if (std::isinf(slew_rate)) return wanted;
  const Input change = {wanted.u1 - before.u1, wanted.u2 - before.u2};
  const double most = slew_rate * std::max(dt, 0.0);
  if (larger(change) <= most) return wanted;
  const Input step = scaled(change, most);
  return {before.u1 + step.u1, before.u2 + step.u2};
}

}  // namespace robsim
