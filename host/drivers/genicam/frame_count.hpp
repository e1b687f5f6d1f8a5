// Which frames have not come, from the camera's own numbers of those that have (GigE Vision's block id, from
// 1 on, USB3 Vision's frame id, from 0 on). Pure; one thread's.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>

namespace strobe::genicam {

struct Counted {
  std::int64_t number = 0;          ///< goes on where ids of 16 bits begin again
  std::int64_t missing_before = 0;  ///< of so many frames nothing has come
  bool began_anew = false;          ///< though the camera was not started
};

class FrameCount {
 public:
  explicit FrameCount(std::int64_t first_id) : first_id_(first_id), last_(first_id - 1) {}

  /// The camera was started: it may go on counting or begin anew.
  void on_start() { started_ = true; }

  /// In the order in which frames began. Without an id (its first packet is missing) it is the next one.
  Counted count(std::optional<std::uint64_t> id) {
    const std::int64_t next = last_ + 1;
    const bool started = std::exchange(started_, false);
    if (!id) return {last_ = next, 0, false};
    const auto own = static_cast<std::int64_t>(*id & kMaxId);
    std::int64_t number = own + turns_ * kTurn;
    // Ids of 16 bits go from 65535 to 1.
    if (number < next && next - number > kTurn / 2 && next - number <= kTurn && !started) {
      ++turns_;
      number += kTurn;
    }
    const bool anew = number < next || (started && number - next > kMaxAfterStart);
    if (!anew) return {last_ = number, number - next, false};
    turns_ = 0;
    last_ = own;
    return {own, own - first_id_ <= kMaxAfterStart ? own - first_id_ : 0, !started};
  }

 private:
  static constexpr std::int64_t kTurn = 65535;
  static constexpr std::int64_t kMaxId = (std::int64_t{1} << 61) - 1;
  /// More are not missing after a start: the camera counts from elsewhere.
  static constexpr std::int64_t kMaxAfterStart = 100;
  std::int64_t first_id_, last_;
  std::int64_t turns_ = 0;
  bool started_ = true;
};

}  // namespace strobe::genicam
