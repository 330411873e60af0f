#include "robsim/base/text/to_text.hpp"

#include <iomanip>
#include <locale>
#include <sstream>

namespace robsim {

std::string to_text(double value) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << std::setprecision(10) << value;
  return text.str();
}

}  // namespace robsim
