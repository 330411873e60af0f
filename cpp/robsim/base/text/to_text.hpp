#pragma once

#include <string>

namespace robsim {

/// A number as messages show it: with ten digits that count, whatever its size.
std::string to_text(double value);

}  // namespace robsim
