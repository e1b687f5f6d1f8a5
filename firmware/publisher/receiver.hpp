// Commands from the message bus: checks that each is sealed with the lab's key for this rig, well-formed,
// addressed to this start of the firmware, not a repetition and not too old, then passes it to the loop or
// the publisher; others are counted and ignored. On a thread of its own, without real-time rights.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <strobe_msgs/command_t.hpp>

#include "common/authentication/key.hpp"
#include "firmware/core/rig.hpp"
#include "firmware/ports/command_source.hpp"
#include "firmware/ports/wake.hpp"
#include "firmware/publisher/loop_queue.hpp"
#include "firmware/publisher/mailbox.hpp"
#include "firmware/publisher/rejections.hpp"

namespace strobe::firmware {

/// From the receiver to the loop: one producer, one consumer, allocated at the start.
class CommandQueue final : public CommandSource {
 public:
  explicit CommandQueue(Wake& loop) : queue_(kCapacity), loop_(loop) {}
  bool pop(Command& command) noexcept override { return queue_.try_dequeue(command); }
  /// False if full. A loop that cannot be woken takes the command in its next turn, Sequencer::kLongestSleep
  /// later at most.
  bool push(const Command& command);

 private:
  static constexpr std::size_t kCapacity = 256;
  SpscQueue<Command> queue_;
  Wake& loop_;
};

/// Remembers the last command of each host: one that is not newer is a repetition, e.g. of a log played back.
/// Nothing is forgotten before the next start.
class RepetitionFilter {
 public:
  /// Hosts are processes that have the key. A day of one `strobe fire` a second has more: the firmware must
  /// then be restarted.
  static constexpr std::size_t kMaxHosts = 65'536;

  /// Returns false if a command of this host with this id or a later one came before, or there are too many
  /// hosts.
  bool is_new(std::int64_t host_id, std::int64_t command_id);

 private:
  std::map<std::int64_t, std::int64_t> newest_;  ///< by host
};

/// What is wrong with a command or with a FIRE's plan; empty if nothing is.
std::string find_defect(const strobe_msgs::command_t& command, const Rig& rig);

/// Why a command that arrives at this instant of CLOCK_BOOTTIME is too old to be obeyed; empty if it is not.
/// A DISARM never is; a RESEND does no harm; a RESET is judged by when a person acted.
std::string find_age(const strobe_msgs::command_t& command, std::int64_t boot_time_ns);

/// A random positive number, from the kernel's generator.
std::int64_t random_id();

class Receiver {
 public:
  /// boot_time_ns: reads CLOCK_BOOTTIME. draw_token: returns a new arm token, not 0. heard_ns: set to the
  /// boot time at which a host was last heard.
  Receiver(const Rig& rig, std::int64_t boot_id, const authentication::Key& key, CommandQueue& commands,
           Mailbox& mailbox, Rejections& rejections, std::function<std::int64_t()> boot_time_ns,
           std::function<std::int64_t()> draw_token = random_id,
           std::atomic<std::int64_t>* heard_ns = nullptr);

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
  std::function<std::int64_t()> boot_time_ns_;
  std::function<std::int64_t()> draw_token_;
  std::atomic<std::int64_t>* heard_ns_;
  RepetitionFilter filter_;
};

}  // namespace strobe::firmware
