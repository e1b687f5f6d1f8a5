// Commands from LCM: addressed to this firmware, not repeated, well-formed; then to the loop or to the
// publisher. Runs on a thread of its own, without real-time rights.
#pragma once

#include <lcm/lcm-cpp.hpp>
#include <map>
#include <stop_token>
#include <strobe_msgs/command_t.hpp>

#include "firmware/ports/command_source.hpp"
#include "firmware/publisher/mailbox.hpp"
#include "firmware/publisher/spsc_queue.hpp"

namespace strobe::firmware {

/// From the receiver to the loop: one producer, one consumer, allocated at the start.
class CommandQueue final : public CommandSource {
 public:
  explicit CommandQueue(int wake_fd) : queue_(kCapacity), wake_fd_(wake_fd) {}
  bool pop(Command& command) noexcept override { return queue_.try_dequeue(command); }
  bool push(const Command& command);  ///< false: full

 private:
  static constexpr std::size_t kCapacity = 256;
  SpscQueue<Command> queue_;
  int wake_fd_;
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

class Receiver {
 public:
  Receiver(const Rig& rig, std::int64_t boot_id, lcm::LCM& lcm, CommandQueue& commands, Mailbox& mailbox);

  void run(const std::stop_token& stop);
  /// One message as received. Never throws.
  void receive(const void* data, int size) noexcept;

 private:
  void handle(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void obey(const strobe_msgs::command_t& command);

  const Rig& rig_;
  std::int64_t boot_id_;
  lcm::LCM& lcm_;
  CommandQueue& commands_;
  Mailbox& mailbox_;
  RepetitionFilter filter_;
};

/// A random number that is not 0, from the kernel's generator.
std::int64_t random_id();

}  // namespace strobe::firmware
