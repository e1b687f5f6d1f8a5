// Counts what the calling thread allocates by operator new: for code that must not.
// CppUTest replaces operator new by one that calls through a pointer; this hooks the pointer.
#pragma once

#include <cstdint>

namespace strobe::testing {

/// Counts from its making on; one object at a time.
class AllocationCounter {
 public:
  AllocationCounter();
  AllocationCounter(const AllocationCounter&) = delete;
  AllocationCounter& operator=(const AllocationCounter&) = delete;
  ~AllocationCounter();
  std::int64_t count() const;  ///< allocations of the thread that made it

 private:
  std::int64_t before_;
};

}  // namespace strobe::testing
