#pragma once

#include <cstdint>

namespace robsim::raw {

/// Turns a row of grey pixels into RGB8. Reads and writes nothing beyond the row.
void mono8_row(const std::uint8_t* raw, int width, std::uint8_t* rgb);

/// Of the high byte first, the lowest `bits` of the two in use.
void mono16_row(const std::uint8_t* raw, int width, int bits, std::uint8_t* rgb);

}  // namespace robsim::raw
