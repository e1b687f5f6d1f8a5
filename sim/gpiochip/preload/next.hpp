// The function of a name that a program would have without this library. Thread-safe.
#pragma once

#include <dlfcn.h>

namespace strobe::sim::gpio {

template <typename Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

}  // namespace strobe::sim::gpio
