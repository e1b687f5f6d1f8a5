// One life of the daemon without its operating system: the shipped loop, queues, publisher, journal and
// receiver on the ports of a virtual lab. One thread's; allocates.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "firmware/core/sequencer.hpp"
#include "firmware/ports/message_bus.hpp"
#include "firmware/publisher/publisher.hpp"
#include "firmware/publisher/receiver.hpp"
#include "firmware/publisher/lcm_bus.hpp"

namespace strobe::soak {

struct FirmwarePorts {
  firmware::Clock& loop_clock;
  firmware::OutputLines& outputs;
  firmware::EdgeSource& edges;
  firmware::MessageBus& bus;
  firmware::Clock& publisher_clock;
  firmware::Wake& loop_wake;
  firmware::Wake& publisher_wake;
};

class FirmwareProcess {
 public:
  struct Settings {
    explicit Settings(const authentication::Key& lab_key) : key(lab_key) {}

    authentication::Key key;
    std::int64_t boot_id = 0;
    std::filesystem::path session;
    std::function<std::int64_t()> draw_token;
    std::function<std::int64_t()> wall_ns;
    std::function<std::int64_t()> boot_time_ns;
    std::function<void(const std::string&)> say;
  };

  /// Fails where the journal cannot be made.
  static Result<std::unique_ptr<FirmwareProcess>> start(const firmware::Rig& rig, const FirmwarePorts& ports,
                                                        const Settings& settings);

  std::int64_t boot_id() const { return boot_id_; }
  firmware::Sequencer& loop() { return sequencer_; }
  firmware::Publisher& publisher() { return publisher_; }
  void receive(const std::vector<std::uint8_t>& bytes) { receiver_.receive(bytes); }
  /// Discards the events that the publisher has not taken yet; returns their number.
  int drop_queue();

 private:
  FirmwareProcess(const firmware::Rig& rig, const FirmwarePorts& ports, const Settings& settings,
                  const firmware::FolderFindings& found, firmware::Journal journal);

  std::int64_t boot_id_;
  firmware::LoopQueue queue_;
  firmware::CommandQueue commands_;
  firmware::Mailbox mailbox_;
  firmware::Journal journal_;
  firmware::SealedBus bus_;
  firmware::TimedOutputs outputs_;
  firmware::Sequencer sequencer_;
  firmware::Publisher publisher_;
  firmware::Rejections rejections_;
  firmware::Receiver receiver_;
};

}  // namespace strobe::soak
