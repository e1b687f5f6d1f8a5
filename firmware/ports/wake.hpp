// Port: tells a thread that sleeps that there is something to do.
#pragma once

namespace strobe::firmware {

/// Real-time safe, from any thread; wakes that nobody has seen yet become one.
class Wake {
 public:
  virtual ~Wake() = default;
  virtual bool wake() noexcept = 0;  ///< false: it failed, try again
};

}  // namespace strobe::firmware
