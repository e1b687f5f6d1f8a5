// A rig's outputs as strobed's two processes hold them: opened before the fork, so that either can make them
// inactive however the other ends.
#pragma once

#include <functional>
#include <memory>

#include "common/result.hpp"
#include "common/units/time.hpp"

namespace strobe::firmware {

class HeldOutputs {
 public:
  virtual ~HeldOutputs() = default;
  /// All of them, the trigger first, whichever fail. Returns false if one did. Real-time safe and
  /// async-signal-safe: no allocation and no lock.
  virtual bool make_inactive() noexcept = 0;
  /// Whether they are known to be inactive once make_inactive() has returned true; else it was asked for.
  virtual bool confirms() const noexcept { return true; }
  /// This process's hold on them; they stay as they are.
  virtual void release() noexcept = 0;
};

/// How strobed comes by a rig's outputs.
struct OutputAccess {
  /// Takes them, inactive from the start. Errors name the rig file's line and key.
  std::function<Result<HeldOutputs*>()> hold;
  /// Makes them inactive once more, anew: of a rig whose strobed is gone, or lost its own hold. Retries for
  /// up to `patience`; fails with what could not be reached, and why.
  std::function<Result<void>(Duration patience)> make_inactive;
};

}  // namespace strobe::firmware
