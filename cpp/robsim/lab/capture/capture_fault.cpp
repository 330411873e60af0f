#include <array>
#include <utility>

#include "robsim/lab/capture/capture_device.hpp"

namespace robsim {

namespace {

constexpr std::array<std::pair<const char*, CaptureFault>, 10> faults{{
    {"no_back_end", CaptureFault::no_back_end},
    {"no_bus", CaptureFault::no_bus},
    {"no_permission", CaptureFault::no_permission},
    {"no_camera", CaptureFault::no_camera},
    {"no_bandwidth", CaptureFault::no_bandwidth},
    {"busy", CaptureFault::busy},
    {"time_out", CaptureFault::time_out},
    {"unplugged", CaptureFault::unplugged},
    {"end", CaptureFault::end},
    {"failed", CaptureFault::failed},
}};

}  // namespace

CaptureFault fault_of(const std::string& name) {
  for (const auto& [key, fault] : faults) {
    if (name == key) return fault;
  }
  return CaptureFault::failed;
}

const char* name_of(CaptureFault fault) {
  for (const auto& [key, value] : faults) {
    if (value == fault) return key;
  }
  return "failed";
}

}  // namespace robsim
