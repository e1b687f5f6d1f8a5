#include "host/commands/web_page.hpp"

#include <CLI/CLI.hpp>

#include <filesystem>
#include <utility>

#include "host/web/http/listen_address.hpp"
#include "host/web/http/page_server.hpp"
#include "host/web/live/live_routes.hpp"

namespace strobe::host {

/// In the order in which they depend on each other.
struct WebPage::Parts {
  explicit Parts(web::LiveSetup setup) : state(std::move(setup), channel, hub) { web::add_live_routes(router, state); }

  web::EventHub hub{web::first_event_id()};
  web::LiveChannel channel;
  web::LiveState state;
  web::Router router;
  std::unique_ptr<web::PageServer> server;
};

void add_web_options(CLI::App& command, WebOptions& options) {
  command
      .add_option_function<std::string>(
          "--web",
          [&options](const std::string& where) {
            options.on = true;
            options.where = where;
          },
          "serve the page on ADDRESS:PORT (default 127.0.0.1:8650; any other address asks for a secret)")
      ->expected(0, 1)
      ->type_name("[WHERE]")
      ->check([](const std::string& where) {
        const auto parsed = web::parse_listen_address(where);
        return parsed ? std::string() : parsed.error().message;
      });
  command.add_option("--web-files", options.files_folder, "read the page's files from this folder, to work on them")
      ->check(CLI::ExistingDirectory);
}

Result<std::unique_ptr<WebPage>> WebPage::open(const WebOptions& options, web::LiveSetup setup, AddRoutes more) {
  if (!options.on) return std::unique_ptr<WebPage>();
  const auto where = web::parse_listen_address(options.where);
  if (!where) return fail("--web: " + where.error().message);
  auto parts = std::make_unique<Parts>(std::move(setup));
  if (more) more(parts->router, parts->hub);
  auto server = web::PageServer::open({where->address, where->port, options.files_folder, {}}, parts->router, parts->hub);
  if (!server) return fail("--web: " + server.error().message);
  parts->server = std::move(*server);
  return std::unique_ptr<WebPage>(new WebPage(std::move(parts)));
}

WebPage::WebPage(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

WebPage::~WebPage() {
  // Work that goes on still needs them: see web::work_left_behind().
  if (!parts_->server->end()) static_cast<void>(parts_.release());
}

web::LiveChannel& WebPage::channel() { return parts_->channel; }
web::EventHub& WebPage::hub() { return parts_->hub; }
std::string WebPage::url() const { return parts_->server->url(); }
std::string WebPage::words() const { return "the page: " + parts_->server->url_with_secret(); }

std::string session_name(const std::string& folder) {
  const std::filesystem::path path = std::filesystem::path(folder).lexically_normal();
  return (path.has_filename() ? path : path.parent_path()).filename().string();
}

}  // namespace strobe::host
