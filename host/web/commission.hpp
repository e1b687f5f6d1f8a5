// Commissioning on the page: the record of a rig, or the run under way, which viewers may confirm and repeat
// as far as it watches inputs alone. Whatever makes outputs move, and each question on what a person saw or
// heard of it, is answered at the console, whatever is sent here. Thread-safe.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/commission/commissioning.hpp"
#include "host/commission/record/record.hpp"
#include "host/config/rig_file.hpp"
#include "host/web/http/event_hub.hpp"
#include "host/web/http/router.hpp"

namespace strobe::web {

/// What a run shows of itself.
struct RunView {
  std::string rig, utc, operator_name;
  double max_age_days = 0.0;
  bool running = true;
  std::vector<commission::StepView> steps;
  std::optional<commission::Prompt> prompt;
  std::string prompted_step;  ///< its id
  std::string waiting;
};
/// Whether only who stands at the rig may answer: what makes outputs move, and what follows on it, seen or
/// heard.
bool asks_at_console(const commission::Prompt& prompt);

/// GET /api/v1/commission: the record, read anew each time. The rig file is read anew, too, if `rig_path` is
/// not empty.
void add_record_route(Router& router, const std::filesystem::path& rig_path);

/// A run under way, between the loop's thread and the network's. Thread-safe; locks are held for a move.
class CommissionRun {
 public:
  /// hub: must outlive the object.
  explicit CommissionRun(EventHub& hub) : hub_(hub) {}

  /// What viewers see from now on; tells them.
  void show(const RunView& run);
  /// What has been asked for since.
  struct Asked {
    enum class Kind { confirm, more_time } kind = Kind::confirm;
    std::string step;  ///< confirm: its id
    std::string from;  ///< the viewer's address
  };
  std::vector<Asked> take_asked();

  // For the network's threads
  std::string json() const;
  /// 200, or why not: 400, 409 where nothing is asked, 403 what only the console answers.
  Response ask(const Request& request, Asked::Kind kind);

 private:
  static constexpr std::size_t kMaxAsked = 16;

  EventHub& hub_;
  mutable std::mutex mutex_;
  std::string json_ = "{}";
  std::string prompted_step_;
  bool prompted_ = false, at_console_ = false;
  std::vector<Asked> asked_;
};

/// GET /api/v1/commission, POST /api/v1/commission/confirm {"step":ID} and …/more_time {}. The run must
/// outlive the router.
void add_run_routes(Router& router, CommissionRun& run);

}  // namespace strobe::web
