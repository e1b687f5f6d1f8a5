// Commands from the message bus: sealed with the lab's key for this rig, addressed to this start of the
// firmware, not repeated, well-formed; then to the loop or to the publisher. What is not is counted and
// ignored. On a thread of its own, without real-time rights.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <strobe_msgs/command_t.hpp>

#include "common/authentication/key.hpp"
#include "firmware/core/rig.hpp"
#include "firmware/ports/command_source.hpp"
#include "firmware/ports/wake.hpp"
#include "firmware/publisher/mailbox.hpp"
#include "firmware/publisher/rejections.hpp"
#include "firmware/publisher/spsc_queue.hpp"

namespace strobe::firmware {

/// From the receiver to the loop: one producer, one consumer, allocated at the start.
class CommandQueue final : public CommandSource {
 public:
  explicit CommandQueue(Wake& loop) : queue_(kCapacity), loop_(loop) {}
  bool pop(Command& command) noexcept override { return queue_.try_dequeue(command); }
  bool push(const Command& command);  ///< false: full

 private:
  static constexpr std::size_t kCapacity = 256;
  SpscQueue<Command> queue_;
  Wake& loop_;
};

/// Remembers the last command of each host: what is not newer is a repetition, e.g. a log that is played
/// back. Nothing is forgotten before the next start, so that nothing old ever becomes news again.
class RepetitionFilter {
 public:
  /// Hosts are processes that have the key; a day of one `strobe fire` each second has more, and then needs
  /// a new start of the firmware.
  static constexpr std::size_t kMaxHosts = 65'536;

  /// False: a command of this host with this id or a later one came before, or it is one host too many.
  bool is_new(std::int64_t host_id, std::int64_t command_id);

 private:
  std::map<std::int64_t, std::int64_t> newest_;  ///< by host
};

/// What is wrong with the form of a command, or with a FIRE's plan; empty: nothing.
std::string find_defect(const strobe_msgs::command_t& command, const Rig& rig);

/// A random number that is not 0, from the kernel's generator.
std::int64_t random_id();

class Receiver {
 public:
  /// draw_token: a fresh arm token; not 0.
  Receiver(const Rig& rig, std::int64_t boot_id, const authentication::Key& key, CommandQueue& commands,
           Mailbox& mailbox, Rejections& rejections, std::function<std::int64_t()> draw_token = random_id);

  /// One message of the command channel as received. Never throws.
  void receive(std::span<const std::uint8_t> sealed) noexcept;

 private:
  void open(std::span<const std::uint8_t> sealed);
  void dispatch(const strobe_msgs::command_t& command);

  const Rig& rig_;
  std::int64_t boot_id_;
  authentication::Key key_;
  CommandQueue& commands_;
  Mailbox& mailbox_;
  Rejections& rejections_;
  std::function<std::int64_t()> draw_token_;
  RepetitionFilter filter_;
};

}  // namespace strobe::firmware
