// The page that a command serves while it runs: its options, and all that is behind it. The object belongs to one thread;
// the page has threads of its own.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "common/result.hpp"
#include "host/web/http/event_hub.hpp"
#include "host/web/http/router.hpp"
#include "host/web/live/live_channel.hpp"
#include "host/web/live/live_state.hpp"

namespace CLI {
class App;
}

namespace strobe::host {

struct WebOptions {
  bool on = false;
  std::string where;         ///< ADDRESS:PORT as typed; may be empty
  std::string files_folder;  ///< of the page's files; empty: those built in
};

/// Adds --web and, for experts, --web-files.
void add_web_options(CLI::App& command, WebOptions& options);

class WebPage {
 public:
  /// Adds further routes; called before the server starts. What they refer to must outlive the page.
  using AddRoutes = std::function<void(web::Router&, web::EventHub&)>;

  /// Null if the page is not asked for. Fails with a line that names the option: a wrong or a taken address.
  static Result<std::unique_ptr<WebPage>> open(const WebOptions& options, web::LiveSetup setup, AddRoutes more = {});
  /// Tells the viewers and closes; takes half a second at most.
  ~WebPage();
  WebPage(const WebPage&) = delete;
  WebPage& operator=(const WebPage&) = delete;

  web::LiveChannel& channel();
  web::EventHub& hub();
  /// "http://127.0.0.1:8650/"
  std::string url() const;
  /// For the person at the console: the address, with the secret if one is needed.
  std::string words() const;

 private:
  struct Parts;
  explicit WebPage(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

/// "run1" of "sessions/run1/"
std::string session_name(const std::string& folder);

}  // namespace strobe::host
