// Commands from the message bus: addressed to this firmware, not repeated, well-formed; then to the loop or
// to the publisher. On a thread of its own, without real-time rights.
#pragma once

#include <functional>
#include <map>
#include <strobe_msgs/command_t.hpp>

#include "firmware/core/rig.hpp"
#include "firmware/ports/command_source.hpp"
#include "firmware/ports/wake.hpp"
#include "firmware/publisher/mailbox.hpp"
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
/// back.
class RepetitionFilter {
 public:
  /// False: a command of this host with this id or a later one came before.
  bool is_news(std::int64_t host_id, std::int64_t command_id);

 private:
  static constexpr std::size_t kMostHosts = 4096;
  struct Seen {
    std::int64_t command_id = 0;
    std::uint64_t order = 0;
  };
  std::map<std::int64_t, Seen> hosts_;
  std::uint64_t order_ = 0;
};

/// Whether bytes can be given to command_t's decoder: all counts and lengths within the message, at most 64
/// notes.
bool well_formed(const std::uint8_t* data, std::size_t size);

/// What is wrong with the form of a command, or with a FIRE's plan; empty: nothing.
std::string defect_of(const strobe_msgs::command_t& command, const Rig& rig);

/// A random number that is not 0, from the kernel's generator.
std::int64_t random_id();

class Receiver {
 public:
  /// draw_token: a fresh arm token; not 0.
  Receiver(const Rig& rig, std::int64_t boot_id, CommandQueue& commands, Mailbox& mailbox,
           std::function<std::int64_t()> draw_token = random_id);

  /// One message of the command channel as received. Never throws.
  void receive(const void* data, int size) noexcept;

 private:
  void obey(const strobe_msgs::command_t& command);

  const Rig& rig_;
  std::int64_t boot_id_;
  CommandQueue& commands_;
  Mailbox& mailbox_;
  std::function<std::int64_t()> draw_token_;
  RepetitionFilter filter_;
};

}  // namespace strobe::firmware
