#pragma once

#include <dlfcn.h>

namespace robsim::virtual_bus {

/// The function of this name that the interposed one stands before: that of the C library, or of a
/// sanitizer.
template <typename Function>
Function* real(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

int real_open(const char* path, int flags, unsigned mode = 0);
int real_close(int descriptor);

}  // namespace robsim::virtual_bus
