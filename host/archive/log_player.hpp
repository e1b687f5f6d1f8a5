// Logs played to a host loop, which computes all readouts again: the loop of every replay. Reads files; one thread's.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/authentication/key.hpp"
#include "common/result.hpp"
#include "host/archive/stored_logs.hpp"
#include "host/loop/host_loop.hpp"

namespace strobe::host {

/// Whether a log has a packet that is sealed with the lab's key. It is then reduced from those alone; a log without, of
/// another lab or of a journal, which is never sealed, as unverified. Absent: it has no message of the rig's firmware.
std::optional<bool> is_sealed(const std::filesystem::path& log, const std::string& rig,
                              const authentication::Key& key);

class LogPlayer {
 public:
  /// key: the logs are sealed with it; absent: they are reduced as unverified. budgets: see AssemblySettings.
  LogPlayer(const RigFile& rig, const std::optional<authentication::Key>& key, bool budgets = false);

  HostLoop& loop() { return loop_; }
  /// When the message that is being played was logged, by the clock of its writer.
  WallTime logged() const { return logged_; }

  /// Told of each message before the loop has it.
  using Watcher = std::function<void(const LogMessage&)>;
  void play(StoredLogs& logs, const Watcher& watcher = {});
  /// Of a journal, whose messages nobody sealed: what the logs lack of it. handler: told of all that is in it.
  void complete_from(StoredLogs& journal, MessageHandler& handler);
  /// No message will come any more.
  void end() { loop_.end_session(); }

 private:
  /// The clock of whoever wrote the logs.
  class LogClock final : public Clock {
   public:
    HostReading read() override { return {HostTime{now}, WallTime{now}, now}; }
    Duration now{};
  };

  std::string rig_;
  LogClock clock_;
  WallTime logged_;
  NullTransport transport_;
  HostLoop loop_;
};

}  // namespace strobe::host
