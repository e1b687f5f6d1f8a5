// strobed: plays shots on a rig's lines. See --help.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <optional>

#include "common/authentication/key_file.hpp"
#include "common/command_line/command_line.hpp"
#include "common/config/default_rig.hpp"
#include "common/config/files.hpp"
#include "common/messages/channels.hpp"
#include "common/wire/lcm_url.hpp"
#include "firmware/check.hpp"
#include "firmware/core/rig.hpp"
#include "firmware/worker/alarm.hpp"
#include "firmware/worker/worker.hpp"

namespace {

using namespace strobe::firmware;  // NOLINT: the program's own

constexpr const char* kFooter =
    "Without --config the example that comes with strobed is taken; its lines exist on the simulated chip "
    "alone, so that "
    "it drives nothing on a real one. --safe and --move-interrupts are for a real rig and want its file "
    "named.\n"
    "Exit status: 0 stopped in good order (or checked, or made safe); 1 the worker died, or a check failed; "
    "2 bad usage, rig file, chip or line.\n"
    "Examples:\n"
    "  strobed --check --config rig.toml --session today\n"
    "  strobed --config rig.toml --session today";

strobe::Result<Rig> load_rig(const std::string& path) {
  const auto text = strobe::config::read_file(path);
  if (!text) return tl::unexpected(text.error());
  auto rig = read_rig(*text, path);
  if (rig && !rig->key_file.empty())
    rig->key_file = (std::filesystem::path(path).parent_path() / rig->key_file).string();
  return rig;
}

int bad_input(const std::string& what) {
  std::fprintf(stderr, "strobed: %s\n", what.c_str());
  return kExitBadInput;
}

/// The lab's key; its fingerprint is printed at the start, so that it can be compared with a host's.
strobe::Result<void> take_key(const Rig& rig, Options& options) {
  const auto found = strobe::authentication::find_key({options.key_file, rig.key_file});
  if (!found) return tl::unexpected(found.error());
  options.key = found->key;
  options.key_words =
      found->path.string() + ", fingerprint " + found->key.fingerprint() + (found->made ? " (new)" : "");
  return {};
}

/// Whoever makes outputs safe must say whose.
strobe::Result<void> choose_rig_file(Options& options, bool must_be_named) {
  if (!options.config.empty()) return {};
  if (must_be_named) return strobe::fail("--config is required: the rig file of the rig that is meant");
  const auto found = strobe::config::rig_file_or_example(options.config, "--config");
  if (!found) return tl::unexpected(found.error());
  std::fprintf(stderr, "strobed: %s\n", strobe::config::example_remark(options.config, "--config").c_str());
  options.config = *found;
  return {};
}

int make_safe(const Rig& rig) {
  const auto takeover = prepare_takeover(rig);
  if (!takeover) return bad_input(takeover.error().message);
  if (auto safe = (*takeover)(strobe::milliseconds(1000)); !safe) {
    std::fprintf(stderr, "strobed: the outputs could not all be made inactive: %s\n",
                 safe.error().message.c_str());
    return kExitFailed;
  }
  return kExitDone;
}

bool read_drill(const std::string& text, Options& options) {
  const std::size_t at = text.find('@');
  options.drill = text.substr(0, at);
  if (at == text.npos || std::find(kDrills.begin(), kDrills.end(), options.drill) == kDrills.end())
    return false;
  const char* end = text.data() + text.size();
  const auto read = std::from_chars(text.data() + at + 1, end, options.drill_at_shot);
  return read.ec == std::errc() && read.ptr == end && options.drill_at_shot >= 1;
}

int run(int argc, char** argv) {
  CLI::App app(
      "Plays strobe-photography shots on a rig's GPIO lines, with a guardian that keeps the outputs safe.");
  app.name("strobed");
  strobe::command_line::set_help(app);
  app.footer(kFooter);
  Options options;
  bool check = false, safe = false, move = false;
  std::string session, drill;
  int trial_s = 10;
  app.add_option("--config", options.config, "rig file (default: the example that comes with strobed)");
  app.add_option("--session", session, "folder of the journal; made if need be");
  app.add_option(
         "--lcm-url", options.lcm_url,
         "overrides the rig file's lcm_url (default " + std::string(strobe::messages::kDefaultLcmUrl) + ")")
      ->check(strobe::wire::lcm_url_problem);
  app.add_option("--key-file", options.key_file,
                 "the lab's key, which commands must be sealed with (default: the rig file's, "
                 "$STROBE_KEY_FILE, systemd's credential lab.key, ~/.config/strobe/lab.key)");
  app.add_flag("--allow-no-rt", options.allow_no_rt, "run without real-time rights, with a warning");
  auto* check_flag =
      app.add_flag("--check", check,
                   "try chip, lines, rights, key, folder and for some seconds the machine, tell "
                   "what is wrong and what mends it, and end");
  app.add_option("--seconds", trial_s, "with --check: how long the machine is tried; 0: not at all")
      ->needs(check_flag)
      ->check(CLI::Range(0, 3600))
      ->capture_default_str();
  app.add_flag("--safe", safe, "drive all outputs inactive once, and end")->excludes(check_flag);
  app.add_flag("--move-interrupts", move,
               "as root: keep this computer's interrupts off the CPU of [real_time] cpu, and end")
      ->excludes(check_flag);
  app.add_option(
      "--drill", drill,
      "lets a part fail at the first flash of this start's shot SHOT, to prove on the real rig that the "
      "outputs become safe: publisher-exception@SHOT and publisher-hang@SHOT (the publishing thread), "
      "loop-hang@SHOT (the real-time loop stands still), output-failure@SHOT (no output can be set)");
  app.add_flag("--json", options.json, "with --check: one JSON object per line");
  app.add_flag("--verbose", options.verbose, "every event on stderr");
  app.set_version_flag("--version", STROBE_VERSION);
  strobe::command_line::for_experts(app,
                                    {"--lcm-url", "--key-file", "--move-interrupts", "--drill", "--verbose"});
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    std::fprintf(stderr, "%s\n", strobe::command_line::complaint(app, error).c_str());
    return kExitBadInput;
  }
  if (!drill.empty() && !read_drill(drill, options)) {
    return bad_input("--drill: must be CAUSE@SHOT with SHOT from 1, is \"" + drill + "\"");
  }
  options.session = session;
  options.trial = std::chrono::seconds(trial_s);
  if (auto found = choose_rig_file(options, safe || move); !found) return bad_input(found.error().message);
  auto rig = load_rig(options.config);
  if (!rig) return bad_input(rig.error().message);
  if (options.lcm_url.empty()) options.lcm_url = rig->lcm_url;
  if (options.lcm_url.empty()) options.lcm_url = strobe::messages::kDefaultLcmUrl;
  options.lcm_url = strobe::wire::to_text(strobe::wire::read_lcm_url(options.lcm_url).value());
  if (safe) return make_safe(*rig);
  if (check) return check_rig(*rig, options);
  if (move) return move_interrupts(*rig);
  if (options.session.empty()) return bad_input("--session is required: the folder for the journal");
  if (auto key = take_key(*rig, options); !key) return bad_input(key.error().message);
  std::optional<Alarm> alarm;
  const auto tell = [&](std::int64_t boot_id, const std::string& message) {
    if (!alarm) alarm.emplace(*rig, options, boot_id);
    alarm->tell(message);
  };
  std::unique_ptr<RigDevice> device;
  const OutputAccess access{[&]() -> strobe::Result<HeldOutputs*> {
                              auto opened = RigDevice::open(*rig);
                              if (!opened) return tl::unexpected(opened.error());
                              device = std::move(*opened);
                              return device.get();
                            },
                            [&](strobe::Duration patience) -> strobe::Result<void> {
                              const auto takeover = prepare_takeover(*rig);
                              if (!takeover) return tl::unexpected(takeover.error());
                              return (*takeover)(patience);
                            }};
  const auto work = [&](SharedStatus& page) { return run_worker(*rig, options, page, *device); };
  return run_guardian(*rig, access, work, tell);
}

}  // namespace

int main(int argc, char** argv) try { return run(argc, argv); } catch (const std::exception& error) {
  std::fprintf(stderr, "strobed: %s\n", error.what());
  return kExitFailed;
}
