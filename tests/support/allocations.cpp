#include "tests/support/allocations.hpp"

#include <CppUTest/PlatformSpecificFunctions.h>

namespace strobe::testing {

namespace {

thread_local std::int64_t allocations = 0;
void* (*uncounted)(std::size_t) = nullptr;

void* counted(std::size_t size) {
  ++allocations;
  return uncounted(size);
}

}  // namespace

AllocationCounter::AllocationCounter() : before_(allocations) {
  uncounted = PlatformSpecificMalloc;
  PlatformSpecificMalloc = counted;
}

AllocationCounter::~AllocationCounter() { PlatformSpecificMalloc = uncounted; }

std::int64_t AllocationCounter::count() const { return allocations - before_; }

}  // namespace strobe::testing
