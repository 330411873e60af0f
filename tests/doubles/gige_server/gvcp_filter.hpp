#pragma once

#include <cstdint>

namespace robsim {

/// Lets Linux drop packets that the fake camera of Aravis (0.8.26) does not survive, as it takes
/// addresses, lengths and sizes for good: only what a GigE Vision client asks reaches the sockets
/// of the control protocol (GVCP) that this process has. Elsewhere it does nothing.
/// `memory_end` is the first address behind the camera's memory and description.
void filter_control_packets(std::uint32_t memory_end);

}  // namespace robsim
