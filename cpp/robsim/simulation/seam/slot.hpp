#pragma once

#include <functional>

namespace robsim {

/// What fills a slot: a native component or a callable of the interpreter's. Empty = off.
template <typename Signature>
struct Slot {
  std::function<Signature> call;
  bool is_interpreted = false;

  explicit operator bool() const { return static_cast<bool>(call); }
};

}  // namespace robsim
