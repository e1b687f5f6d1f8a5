// Reports of sessions, made on a thread of their own since they may take long: the newest is kept. Thread-safe.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "host/archive/read_session.hpp"
#include "host/web/http/worker.hpp"

namespace strobe::web {

/// What `strobe report SESSION` writes without options.
std::string session_report_html(const host::StoredSession& session, const std::string& version,
                                const std::function<void(std::size_t done, std::size_t of)>& progress);

class ReportMaker {
 public:
  explicit ReportMaker(std::string version) : version_(std::move(version)) {}

  struct State {
    std::shared_ptr<const std::string> html;  ///< null: it is being made
    std::size_t done = 0, of = 0;             ///< pieces of work
    std::string problem;                      ///< why it cannot be made; else empty
  };
  /// The session's report in this state. Begins to make it if that is not under way; another's is waited for first.
  State report(const std::string& id, const std::string& state,
               std::shared_ptr<const host::StoredSession> session);

 private:
  struct Made {
    std::mutex mutex;
    std::string id, state;  ///< of what is made, or was
    std::shared_ptr<const std::string> html;
    std::string problem;
    std::size_t done = 0, of = 0;
    bool busy = false;
  };

  std::string version_;
  std::shared_ptr<Made> made_ = std::make_shared<Made>();
  Worker worker_{1};
};

}  // namespace strobe::web
