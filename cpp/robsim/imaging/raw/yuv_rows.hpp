#pragma once

#include <cstdint>

namespace robsim::raw {

/// Turns a row of pixels into RGB8. Reads and writes nothing beyond the row.
void yuv411_row(const std::uint8_t* raw, int width, std::uint8_t* rgb);
void yuv422_row(const std::uint8_t* raw, int width, std::uint8_t* rgb);
void yuv444_row(const std::uint8_t* raw, int width, std::uint8_t* rgb);

}  // namespace robsim::raw
