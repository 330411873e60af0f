#include "robsim/vision/color/color_class.hpp"

#include <stdexcept>

namespace robsim {

void check_color_class(const ColorClass& color) {
  if (color.name.empty()) throw std::invalid_argument("name of a colour class must not be empty");
  const char* const channels[] = {"y", "u", "v"};
  for (std::size_t i = 0; i < 3; ++i) {
    if (color.lower[i] < 0 || color.lower[i] > color.upper[i] || color.upper[i] > 255) {
      throw std::invalid_argument(std::string(channels[i]) + " of colour class '" + color.name +
                                  "' must be a range within 0..255, lower end first, got [" +
                                  std::to_string(color.lower[i]) + ", " +
                                  std::to_string(color.upper[i]) + "]");
    }
  }
}

}  // namespace robsim
