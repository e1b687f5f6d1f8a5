// strobe protocol: the test protocols that there are, one in words, and the verdict on shots that were fired.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/command_line/command_line.hpp"
#include "common/messages/parsed_json.hpp"
#include "host/archive/read_session.hpp"
#include "host/commands/command.hpp"
#include "host/commands/protocol_json.hpp"
#include "host/commands/shared_options.hpp"
#include "host/commands/terminal.hpp"
#include "host/protocol/evaluation.hpp"
#include "host/protocol/evaluation_text.hpp"
#include "host/protocol/session_protocol.hpp"
#include "host/series/select.hpp"

namespace strobe::host {
namespace {

struct VerdictOptions {
  std::vector<std::string> sessions;
  std::string protocol;
  SessionOptions session;
  bool json = false;
};

int list_protocols() {
  const auto names = protocol::shipped_protocols();
  if (!names) return bad_input("protocol: " + names.error().message);
  for (const std::string& name : *names) {
    const auto one = protocol::load_protocol(name);
    if (!one) return bad_input("protocol: " + one.error().message);
    const char* const unread =
        one->source.read == protocol::SourceRead::not_read ? " (verdict withheld)" : "";
    std::printf("%-28s %s%s\n", name.c_str(), one->title.c_str(), unread);
  }
  return kDone;
}

int check_protocol(const std::string& name) {
  const auto one = protocol::load_protocol(name);
  if (!one) return bad_input("protocol: " + one.error().message);
  print(protocol::explanation(*one));
  return kDone;
}

/// Of --protocol, else the first session's own.
Result<protocol::SessionProtocol> protocol_for(const VerdictOptions& options) {
  auto own = protocol::protocol_of_session(options.sessions.front());
  if (!options.protocol.empty()) {
    auto asked = protocol::load_protocol(options.protocol);
    if (!asked) return fail("--protocol: " + asked.error().message);
    return protocol::SessionProtocol{std::move(*asked), "", own && *own ? (*own)->seed : 0};
  }
  if (!own) return tl::unexpected(own.error());
  if (!*own) return fail(options.sessions.front() + " was fired for no protocol; give one with --protocol");
  return std::move(**own);
}

int give_verdict(const VerdictOptions& options) {
  const auto asked = protocol_for(options);
  if (!asked) return bad_input("protocol: " + asked.error().message);
  Terminal terminal(Terminal::style(options.json, true));
  std::vector<Shot> shots;
  for (const std::string& folder : options.sessions) {
    const auto session = read_for(terminal, folder, options.session);
    if (!session) return bad_input(session.error().message);
    const std::string name = options.sessions.size() > 1 ? folder : "";
    for (Shot& shot : series_shots(*session, name)) shots.push_back(std::move(shot));
  }
  const protocol::Evaluation evaluation = protocol::evaluate(asked->protocol, asked->seed, shots);
  if (options.json)
    print({messages::json_text(evaluation_json(asked->protocol, evaluation))});
  else
    print(protocol::text(asked->protocol, evaluation));
  return evaluation.outcome == protocol::Outcome::pass ? kDone : kFailed;
}

}  // namespace

void add_protocol_command(CLI::App& app, int& exit_status) {
  CLI::App* command = app.add_subcommand("protocol", "Test protocols: list, explain, give the verdict");
  command->require_subcommand(1);
  command->footer(
      "Example: strobe protocol check itf-court-pace\n"
      "Exit status: 1 where the verdict is not a pass, 2 for bad usage or input.");
  CLI::App* list = command->add_subcommand("list", "The protocols that come with strobe");
  list->footer("Example: strobe protocol list");
  list->callback([&exit_status] { exit_status = list_protocols(); });

  auto name = std::make_shared<std::string>();
  CLI::App* check = command->add_subcommand("check", "One in words: what will happen and be decided");
  check->add_option("NAME", *name, "A shipped protocol, or a file that ends in .toml")->required();
  check->footer("Example: strobe protocol check itf-court-pace");
  check->callback([name, &exit_status] { exit_status = check_protocol(*name); });

  auto options = std::make_shared<VerdictOptions>();
  CLI::App* verdict =
      command->add_subcommand("verdict", "Values, verdicts and what is left, of stored sessions");
  verdict->add_option("SESSION", options->sessions, "Session folders, oldest first")->required();
  verdict->add_option("--protocol", options->protocol,
                      "A shipped protocol or a file (default: the first session's)");
  add_session_options(*verdict, options->session);
  verdict->add_flag("--json", options->json, "One JSON object; nothing else on standard output");
  command_line::for_experts(*verdict, {"--rig", "--key-file"});
  verdict->footer(
      "Example: strobe protocol verdict run1\n"
      "Exit status: 1 where it is not a pass, 2 for bad usage or input.");
  verdict->callback([options, &exit_status] { exit_status = give_verdict(*options); });
}

}  // namespace strobe::host
