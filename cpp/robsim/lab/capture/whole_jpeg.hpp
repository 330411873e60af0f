#pragma once

#include <cstddef>
#include <cstdint>

namespace robsim {

/// True if a JPEG image has all of its blocks, and nothing else, between its header and its end
/// marker: ITU-T T.81. Decoders fill up what is missing, and do not say so. Of progressive and
/// arithmetic coding the end marker alone is looked at.
bool is_whole_jpeg(const std::uint8_t* data, std::size_t size);

}  // namespace robsim
