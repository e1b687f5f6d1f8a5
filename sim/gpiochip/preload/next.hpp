// The function of a name that a program would have without this library. Thread-safe.
#pragma once

#include <dlfcn.h>

/// What a program calls of this library.
#define STROBE_EXPORT extern "C" __attribute__((visibility("default")))

namespace strobe::sim::gpio {

template <typename Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

/// Of glibc's condition variables, whose first version, which dlsym() would find, has another layout.
template <typename Function>
Function* next_of_condition(const char* name) {
  void* const found = dlvsym(RTLD_NEXT, name, "GLIBC_2.3.2");
  return found != nullptr ? reinterpret_cast<Function*>(found) : next<Function>(name);
}

}  // namespace strobe::sim::gpio
