#include "host/archive/played_session.hpp"

#include <utility>

namespace strobe::host {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kProgressEvery = 2000;  // messages

void add(std::vector<std::string>& remarks, std::vector<std::string> more) {
  for (std::string& text : more) remarks.push_back(std::move(text));
}

}  // namespace

Result<PlayedSession> play_session(const std::vector<fs::path>& logs, const std::vector<fs::path>& journals,
                                   const RigFile& rig, const std::optional<authentication::Key>& key,
                                   const std::function<void(double)>& progress) {
  auto stored = StoredLogs::open(logs);
  if (!stored) return tl::unexpected(stored.error());
  PlayedSession played;
  played.player = std::make_unique<LogPlayer>(rig, key);
  played.fired = std::make_unique<FiredShots>(*played.player, rig.rig);
  played.player->play(*stored, [&](const LogMessage& message) {
    played.fired->watch(message);
    if (progress && stored->messages() % kProgressEvery == 0) progress(stored->share());
  });
  add(played.remarks, stored->remarks());
  for (const auto& [host, heard] : played.fired->commanding_hosts())
    played.log_of_host[host] = stored->path(heard.log);
  played.fired->begin_journals();
  for (const fs::path& path : journals) {
    auto journal = StoredLogs::open({path});
    if (!journal) return tl::unexpected(journal.error());
    played.player->complete_from(*journal, *played.fired);
    add(played.remarks, journal->remarks());
  }
  played.player->end();
  return played;
}

}  // namespace strobe::host
