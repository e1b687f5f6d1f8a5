// Session folders as the real SessionFolder writes them, with synthetic shots: what one host hears and sends, in virtual
// time. One thread's.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <strobe_msgs/event_t.hpp>

#include "common/authentication/key.hpp"
#include "common/messages/channels.hpp"
#include "host/messages/command_factory.hpp"
#include "host/session/session_folder.hpp"
#include "tests/host/synthetic_shot.hpp"
#include "tests/support/sealed_sender.hpp"

namespace strobe::host_test {

/// A log that lies in the folder until this is destroyed.
class WrittenRun {
 public:
  static constexpr std::int64_t kBoot = 77;

  /// Starts at that second of the day. key: seals all; the rig's file is written if there is none.
  WrittenRun(const std::filesystem::path& folder, const authentication::Key& key, std::int64_t host_id,
             int second, const std::string& rig_text = "rig = \"bench\"\n[machine]\nlag_ms = 310\n");

  /// The record of the shots from here on.
  std::vector<std::pair<std::string, std::string>> notes{};
  /// The firmware's clock; every message moves it, and the log's time, by a millisecond.
  std::int64_t mono_ns = 4'000'000'000'000;
  void wait_s(double seconds);

  void heartbeat(std::int64_t boot_id = kBoot);
  void arm_and_fire(std::int64_t boot_id = kBoot);
  void started(int shot_id, std::int64_t boot_id = kBoot, std::int64_t by_host = 0, bool dry = false);
  void flash(int shot_id, std::int64_t boot_id = kBoot);
  void ended(int shot_id, std::int64_t boot_id = kBoot);
  /// With the events that were sent for it since started().
  void summary(int shot_id, std::int64_t boot_id = kBoot, std::int64_t by_host = 0, std::uint32_t seed = 1,
               const std::string& abort_reason = {});
  void frame(int shot_id, std::int64_t boot_id = kBoot, const std::string& photograph = "",
             std::uint32_t seed = 1);
  /// All of a shot, one after the other.
  void shot(int shot_id, const std::string& photograph = "");
  void result(int shot_id, const std::string& utc, std::int64_t boot_id = kBoot);

  template <typename Message>
  void log(messages::Channel channel, const Message& message) {
    const std::string name = messages::channel_name("bench", channel);
    log_bytes(name, sender_.packet(name, message));
  }
  void log_bytes(const std::string& channel, const std::vector<std::uint8_t>& bytes);
  host::SessionFolder& folder() { return *folder_; }
  std::int64_t host_id() const { return host_id_; }

  /// Of the boot's newest event; two runs that follow each other share it.
  std::int64_t sequence = 0;

 private:
  void event(std::int8_t kind, int shot_id, std::int64_t boot_id, const std::string& detail = "");

  authentication::Key key_;
  std::int64_t host_id_;
  testing::SealedSender sender_;
  WallTime wall_;
  std::unique_ptr<host::SessionFolder> folder_;
  std::int64_t first_sequence_ = 0;
};

}  // namespace strobe::host_test
