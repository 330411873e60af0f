#pragma once

namespace robsim {

/// Time of a clock that nobody sets, and that Python's time.monotonic() shows, too (s).
double monotonic_now();

/// Sleeps until this time of it (s).
void sleep_until(double time);

}  // namespace robsim
