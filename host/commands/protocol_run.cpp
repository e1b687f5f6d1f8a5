#include "host/commands/protocol_run.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "common/messages/parsed_json.hpp"
#include "host/commands/command.hpp"
#include "host/commands/protocol_json.hpp"
#include "host/commands/terminal.hpp"
#include "host/config/notes.hpp"
#include "host/protocol/evaluation.hpp"
#include "host/protocol/evaluation_text.hpp"
#include "host/protocol/session_protocol.hpp"
#include "host/series/select.hpp"
#include "host/session/session_folder.hpp"

namespace strobe::host {
namespace {

namespace fs = std::filesystem;

class ProtocolRun {
 public:
  ProtocolRun(FireOptions options, protocol::Protocol protocol, const HostReading& asked,
              const FireBlock& fire)
      : options_(std::move(options)), protocol_(std::move(protocol)), asked_(asked), fire_(fire) {}

  int run() {
    bool first = true;
    std::optional<protocol::Cell> cell;
    for (;;) {
      const auto evaluation = evaluate();
      if (!evaluation) return bad_input(evaluation.error().message);
      tell_replaced(*evaluation);
      if (evaluation->blocks.empty() || evaluation->out_of_replacements) return conclude(*evaluation);
      const protocol::Block& block = evaluation->blocks.front();
      if (first) tell_preparation(*evaluation);
      const bool changed = !cell || *cell != block.cell;
      tell(fmt::format("next: {}; {} blocks left", block.words, evaluation->blocks.size()));
      if (!first && changed && !options_.no_pause && !confirmed())
        return failed(interrupted_words(*evaluation));
      cell = block.cell;
      first = false;
      if (const int status = fire_(block_options(block, *evaluation), asked_); status == kBadInput)
        return status;
      else if (status != kDone)
        return failed(interrupted_words(*evaluation));
    }
  }

 private:
  /// Of what the session holds by now.
  Result<protocol::Evaluation> evaluate() const {
    std::vector<Shot> shots;
    if (fs::exists(fs::path(options_.session) / "runs.jsonl")) {
      const auto session = read_session(options_.session, {"", options_.paths.key_file, {}});
      if (!session) return tl::unexpected(session.error());
      shots = series_shots(*session, "");
    }
    return protocol::evaluate(protocol_, options_.protocol_seed, shots);
  }

  FireOptions block_options(const protocol::Block& block, const protocol::Evaluation& evaluation) const {
    FireOptions options = options_;
    options.shots = block.shots;
    options.until.reset();
    if (protocol_.impact.kind == protocol::ImpactKind::dropped)
      options.drop_height_m = protocol_.impact.drop_height_m;
    options.retries = std::max(0, protocol_.replacements - evaluation.replaced);
    options.notes.push_back(fmt::format("{}={}", protocol::kProtocolNote, protocol_.name));
    options.notes.push_back(fmt::format("{}={}", protocol::kPositionNote, block.cell.position));
    options.notes.push_back(fmt::format("{}={}", protocol::kBallNote, block.cell.ball));
    options.heading = fmt::format("{}: {}", protocol_.name, block.words);
    return options;
  }

  void tell(const std::string& text) const { std::fprintf(stderr, "strobe: %s\n", text.c_str()); }

  void tell_preparation(const protocol::Evaluation& evaluation) const {
    tell(protocol_.title);
    const bool begun = !evaluation.shots.empty();
    if (begun) return tell("going on with what the session holds");
    for (const std::string& sentence : protocol_.preparation) tell(sentence);
  }

  /// Shots since the last look that have to be fired again.
  void tell_replaced(const protocol::Evaluation& evaluation) {
    for (; told_ < evaluation.shots.size(); ++told_) {
      const protocol::UsedShot& shot = evaluation.shots[told_];
      if (shot.use == protocol::Use::not_conforming)
        tell(fmt::format("shot {} is fired again: {}", shot.shot, shot.why));
    }
  }

  /// A person at the terminal has made the change. A stop while waiting is a no.
  bool confirmed() {
    std::fprintf(stderr, "strobe: press Enter when that is done and nobody is in the lane (Ctrl-C ends) ");
    std::fflush(stderr);
    while (!interrupted()) {
      pollfd input{STDIN_FILENO, POLLIN, 0};
      if (::poll(&input, 1, kPatience_ms) <= 0) continue;
      char typed = 0;
      const ssize_t count = ::read(STDIN_FILENO, &typed, 1);
      if (count <= 0) return false;  // nobody is there
      if (typed == '\n') {
        asked_ = MachineClock().read();
        return true;
      }
    }
    return false;
  }

  std::string interrupted_words(const protocol::Evaluation& evaluation) const {
    return fmt::format("{} blocks of {} are left; go on with: strobe fire --resume --session {}",
                       evaluation.blocks.size(), protocol_.name, options_.session);
  }

  int conclude(const protocol::Evaluation& evaluation) const {
    print(options_.json ? std::vector{messages::json_text(evaluation_json(protocol_, evaluation))}
                        : protocol::text(protocol_, evaluation));
    return evaluation.outcome == protocol::Outcome::pass ? kDone : kFailed;
  }

  /// How soon a Ctrl-C is noticed while a person is waited for.
  static constexpr int kPatience_ms = 100;

  FireOptions options_;
  protocol::Protocol protocol_;
  HostReading asked_;
  const FireBlock& fire_;
  std::size_t told_ = 0;  ///< of the session's shots
};

/// The session's, or the one that was asked for where the session has none yet. Fails where these differ.
Result<protocol::SessionProtocol> chosen_protocol(const FireOptions& options) {
  auto stored = protocol::protocol_of_session(options.session);
  if (!stored) return tl::unexpected(stored.error());
  if (*stored && options.resume) return std::move(**stored);
  auto text = protocol::protocol_text(options.protocol);
  if (!text) return tl::unexpected(text.error());
  if (*stored && (*stored)->text != *text)
    return fail(fmt::format("--protocol: session {} was fired for another one ({})", options.session,
                            (*stored)->protocol.title));
  if (*stored) return std::move(**stored);
  auto protocol = protocol::read_protocol(*text, options.protocol);
  if (!protocol) return tl::unexpected(protocol.error());
  return protocol::SessionProtocol{std::move(*protocol), std::move(*text),
                                   static_cast<std::uint64_t>(options.protocol_seed)};
}

/// Fails, naming the first input that nobody has stated, or one beyond what the protocol allows.
Result<void> check_inputs(const protocol::Protocol& protocol, const FireOptions& options,
                          const RigFile& rig) {
  reduction::Record notes = rig.record;
  for (const std::string& note : options.notes)
    if (auto added = add_note(notes, note); !added) return fail("--note: " + added.error().message);
  for (const protocol::Input& input : protocol.inputs) {
    if (input.value) continue;
    const auto number = note_number(notes, input.name);
    if (!number)
      return fail(fmt::format("{} needs {}: state it with --note {}=NUMBER, in {}", protocol.name,
                              input.words, input.name, input.unit));
    if (*number < input.allowed.low || *number > input.allowed.high)
      return fail(fmt::format("{}: {} is {}, must be {}", protocol.name, input.name, *number,
                              protocol::words(input.allowed)));
  }
  return {};
}

}  // namespace

int run_protocol(const FireOptions& given, const HostReading& asked, const FireBlock& fire) {
  FireOptions options = given;
  if (options.session.empty()) options.session = "session-" + utc_for_file(asked.wall);
  auto chosen = chosen_protocol(options);
  if (!chosen) return bad_input(chosen.error().message);
  options.protocol = chosen->protocol.name;
  options.protocol_text = chosen->text;
  options.protocol_seed = static_cast<int>(chosen->seed);
  const auto rig = load_rig(options.paths.rig_path);
  if (!rig) return bad_input(rig.error().message);
  if (auto checked = check_inputs(chosen->protocol, options, *rig); !checked)
    return bad_input(checked.error().message);
  const std::string wanted = chosen->protocol.ball_kind;
  const std::string kind = rig->ball.kind_name.empty() ? "tennis" : rig->ball.kind_name;
  if (!wanted.empty() && !kind.starts_with(wanted))
    std::fprintf(stderr, "strobe: %s asks for a ball of kind %s; the rig file has %s\n",
                 options.protocol.c_str(), wanted.c_str(), kind.c_str());
  return ProtocolRun(options, std::move(chosen->protocol), asked, fire).run();
}

}  // namespace strobe::host
