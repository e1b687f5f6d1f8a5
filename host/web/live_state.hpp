// What the page shows of a host that runs: kept up to date on a background thread from what the loop tells
// (live_feed.hpp), published as events, ready as JSON (host/web/README.md); and what it asks of the host.
// Thread-safe.
#pragma once

#include <memory>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "common/data/thesis_data.hpp"
#include "host/series/series.hpp"
#include "host/web/http/event_hub.hpp"
#include "host/web/http/router.hpp"
#include "host/web/live_channel.hpp"
#include "host/web/shot_json.hpp"

namespace strobe::web {

/// STATUS of the interface. Pure.
nlohmann::ordered_json status_json(const LiveStatus& status);

/// Of the program, as long as it runs.
struct LiveSetup {
  std::string program;  ///< "fire", "live" or "commission"
  std::string version;  ///< of strobe
  std::string rig;
  std::optional<std::string> session;  ///< the folder's name; absent: nothing is kept
  std::optional<thesis::Condition> thesis{};
};

class LiveState {
 public:
  /// Both must outlive the object.
  LiveState(LiveSetup setup, LiveChannel& channel, EventHub& hub);
  ~LiveState();
  LiveState(const LiveState&) = delete;
  LiveState& operator=(const LiveState&) = delete;

  /// {"program",…}: of GET /api/v1/live.
  std::string live_json() const;
  /// Of GET /api/v1/timing; absent: no firmware was heard.
  std::optional<std::string> timing_json() const;

  /// 202: the host's loop has it, and does it in the same turn; 400; 409: it cannot do that now; 503: the
  /// loop stands still and gets it when it goes on, or has not come to what it was asked before. Waits for a
  /// second at most: LiveChannel::command().
  Response ask(const Request& request, LiveCommand::Kind kind);

  static constexpr std::size_t kMaxNotifications = 50;

 private:
  /// Shots of one condition.
  struct LiveSeries {
    host::Shot first;  ///< what says which: record and rig
    host::Series series;
    std::vector<ShotRow> rows;
  };

  void run();
  void take(LiveStatus status);
  void take(host::Shot shot);
  void take(LiveNotification notification);
  LiveSeries& series_like(const host::Shot& shot);
  void publish_series();

  const LiveSetup setup_;
  LiveChannel& channel_;
  EventHub& hub_;

  // The thread's alone.
  std::vector<LiveSeries> all_series_;  ///< the newest shot's last
  std::vector<ShotKey> shots_;

  mutable std::mutex mutex_;
  LiveStatus status_;
  int last_shot_id_ = 0;
  std::string series_text_ = "null", last_text_ = "null";
  std::vector<std::string> notifications_;  ///< as JSON
  std::thread thread_;
};

/// /api/v1/live, /timing, and to stop and to disarm. The state must outlive the router. All answer quickly.
void add_live_routes(Router& router, LiveState& state);

}  // namespace strobe::web
