// The page that a command serves while it runs: its options, and all that is behind it. The object belongs to
// one thread; the page has threads of its own.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/data/thesis_data.hpp"
#include "common/result.hpp"
#include "host/config/rig_file.hpp"
#include "host/loop/host_loop.hpp"
#include "host/view/render.hpp"
#include "host/web/http/event_hub.hpp"
#include "host/web/http/router.hpp"
#include "host/web/live_feed.hpp"

namespace CLI {
class App;
}

namespace strobe::host {

struct WebOptions {
  bool on = false;
  std::string where;     ///< ADDRESS:PORT as typed; may be empty
  std::string sessions;  ///< the folder whose sessions are shown; empty: the command's own choice
};

/// Adds --web and, for experts, --sessions.
void add_web_options(CLI::App& command, WebOptions& options);

/// What the page is told of the command.
struct WebSetup {
  std::string program;   ///< "fire", "live" or "commission"
  std::string version;   ///< of strobe
  std::string session;   ///< folder that this run writes; empty: none
  std::string key_file;  ///< as of --key-file
  std::optional<thesis::Condition> condition{};
};

class WebPage {
 public:
  /// Adds further routes; called before the server starts. What they refer to must outlive the page.
  using AddRoutes = std::function<void(web::Router&, web::EventHub&)>;

  /// Null if the page is not asked for. Fails with a line that names the option: a wrong or a taken address.
  static Result<std::unique_ptr<WebPage>> open(const WebOptions& options, const WebSetup& setup,
                                               const RigFile& rig, const AddRoutes& more = {});
  /// Tells the viewers and closes; takes half a second at most.
  ~WebPage();
  WebPage(const WebPage&) = delete;
  WebPage& operator=(const WebPage&) = delete;

  /// "http://127.0.0.1:8650/"
  std::string url() const;
  /// For the person at the console: the address, with the secret if one is needed.
  std::string address_remark() const;

  // For the loop's thread.
  /// The page is told what happens on this loop, which it must outlive. shown: whether a host's shots are;
  /// empty: all are.
  void attach(HostLoop& loop, Clock& clock, std::function<bool(std::int64_t host_id)> shown = {});
  /// What viewers ask for; wakes the loop.
  std::vector<web::LiveCommand> take_commands();
  /// After each turn of the loop.
  void step(HostLoop& loop, const ViewModel& model, const web::Progress& progress);

 private:
  struct Parts;
  explicit WebPage(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace strobe::host
