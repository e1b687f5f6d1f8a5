#include "host/commands/web_page.hpp"

#include <CLI/CLI.hpp>

#include <filesystem>
#include <utility>

#include "host/web/archive_routes.hpp"
#include "host/web/editing.hpp"
#include "host/web/http/page_server.hpp"
#include "host/web/live_state.hpp"

namespace strobe::host {

namespace fs = std::filesystem;

namespace {

/// "run1" of "sessions/run1/"
fs::path without_end_slash(const fs::path& folder) {
  const fs::path path = fs::absolute(folder).lexically_normal();
  return path.has_filename() ? path : path.parent_path();
}

std::optional<std::string> session_of(const WebSetup& setup) {
  if (setup.session.empty()) return std::nullopt;
  return web::session_id(without_end_slash(setup.session).filename().string());
}

web::SessionStoreSettings store_settings(const WebOptions& options, const WebSetup& setup) {
  const fs::path own =
      setup.session.empty() ? fs::current_path() : without_end_slash(setup.session).parent_path();
  return {options.sessions.empty() ? own : fs::path(options.sessions), session_of(setup).value_or(""),
          setup.key_file, setup.version};
}

}  // namespace

/// In the order in which they depend on each other.
struct WebPage::Parts {
  Parts(const WebOptions& options, const WebSetup& setup, const RigFile& rig)
      : state({setup.program, setup.version, rig.rig, session_of(setup), setup.condition}, channel, hub),
        archive(store_settings(options, setup)),
        editing(archive, hub) {
    web::add_live_routes(router, state);
    web::add_archive_routes(router, archive);
    web::add_editing_routes(router, editing);
    if (setup.session.empty()) return;
    newest.emplace(without_end_slash(setup.session), std::make_shared<const RigFile>(rig),
                   [this](std::int64_t host) { return !shown || shown(host); });
    archive.sessions.set_live_shots(&*newest);
  }

  web::EventHub hub{web::first_event_id()};
  web::LiveChannel channel;
  web::LiveState state;
  std::function<bool(std::int64_t)> shown;  // the loop's thread's, like the feed
  std::optional<web::LiveShots> newest;
  web::Archive archive;
  web::Editing editing;
  web::Router router;
  std::optional<web::LiveFeed> feed;
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
  command
      .add_option(
          "--sessions", options.sessions,
          "the folder whose sessions the page shows (default: that of --session, else the current one)")
      ->check(CLI::ExistingDirectory);
}

Result<std::unique_ptr<WebPage>> WebPage::open(const WebOptions& options, const WebSetup& setup,
                                               const RigFile& rig, const AddRoutes& more) {
  if (!options.on) return std::unique_ptr<WebPage>();
  const auto where = web::parse_listen_address(options.where);
  if (!where) return fail("--web: " + where.error().message);
  auto parts = std::make_unique<Parts>(options, setup, rig);
  if (more) more(parts->router, parts->hub);
  auto server = web::PageServer::open({*where}, parts->router, parts->hub);
  if (!server) return fail("--web: " + server.error().message);
  parts->server = std::move(*server);
  return std::unique_ptr<WebPage>(new WebPage(std::move(parts)));
}

WebPage::WebPage(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

WebPage::~WebPage() {
  parts_->channel.end();  // nobody takes commands any more
  // Work that goes on still needs them: see web::work_left_behind().
  if (!parts_->server->end()) static_cast<void>(parts_.release());
}

std::string WebPage::url() const { return parts_->server->url(); }
std::string WebPage::address_remark() const { return "the page: " + parts_->server->url_with_secret(); }

void WebPage::attach(HostLoop& loop, Clock& clock, std::function<bool(std::int64_t)> shown) {
  parts_->shown = shown;
  if (parts_->newest) loop.add_listener(*parts_->newest);
  parts_->feed.emplace(parts_->channel, clock);
  parts_->feed->show_only(std::move(shown));
  loop.add_listener(*parts_->feed);
  loop.set_wake_descriptor(parts_->channel.descriptor());
}

std::vector<web::LiveCommand> WebPage::take_commands() { return parts_->feed->take_commands(); }

void WebPage::step(HostLoop& loop, const ViewModel& model, const web::Progress& progress) {
  parts_->feed->step(loop, model, progress);
}

}  // namespace strobe::host
