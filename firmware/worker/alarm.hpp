// Tells the hosts that outputs may be active which strobed can no longer switch off: a status under the
// worker's boot, sent by the guardian once the worker is dead. Not real-time; one thread's.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "firmware/core/rig.hpp"
#include "firmware/worker/options.hpp"

namespace strobe::firmware {

class Alarm {
 public:
  /// boot_id: the dead worker's; 0: it had none, and nothing is told. Without a network nothing is, either.
  Alarm(const Rig& rig, const Options& options, std::int64_t boot_id);
  ~Alarm();
  Alarm(const Alarm&) = delete;
  Alarm& operator=(const Alarm&) = delete;

  /// Sends a status with this message, once.
  void tell(const std::string& message);

 private:
  struct Network;
  std::unique_ptr<Network> network_;
};

}  // namespace strobe::firmware
