// Port: wakes a sleeping thread.
#pragma once

namespace strobe::firmware {

/// Real-time safe, from any thread; several calls before the thread wakes count as one.
class Wake {
 public:
  virtual ~Wake() = default;
  virtual bool wake() noexcept = 0;  ///< false if it failed: try again
};

}  // namespace strobe::firmware
