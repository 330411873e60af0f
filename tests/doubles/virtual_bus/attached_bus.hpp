#pragma once

#include <string>

#include "virtual_bus/bus_memory.hpp"

namespace robsim::virtual_bus {

/// The bus that the environment names; null if it names none, or what it names is no bus.
BusMemory* attached_bus();

/// Number of the device node in "/dev/fw1"; -1 if it is none of the bus that is attached. Node 0 is
/// the computer, node n > 0 camera n - 1.
int node_of(const BusMemory& bus, const char* path);

/// Whether a node is there.
bool is_there(const BusMemory& bus, int node);

}  // namespace robsim::virtual_bus
