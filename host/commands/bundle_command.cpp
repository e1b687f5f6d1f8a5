// strobe bundle: a session handed over as one file, and such a file verified and computed again.
#include <unistd.h>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <optional>

#include "common/command_line/command_line.hpp"
#include "host/clock/machine_clock.hpp"
#include "host/commands/command.hpp"
#include "host/commands/shared_options.hpp"
#include "host/commands/terminal.hpp"
#include "host/external/program.hpp"
#include "host/interlaboratory/bundle.hpp"
#include "host/session/run_lock.hpp"

namespace strobe::host {

namespace {

namespace fs = std::filesystem;

struct BundleOptions {
  std::string session, out, check, into;
  SessionOptions reading;
};

int hand_over(const BundleOptions& options) {
  if (options.out.empty()) return bad_input("bundle: give --out FILE.tar");
  std::error_code error;
  if (!fs::is_directory(options.session, error)) return bad_input(options.session + ": no such folder");
  // Nobody may write there meanwhile; where this user cannot write, nobody is asked.
  std::optional<RunLock> held;
  if (access(options.session.c_str(), W_OK) == 0) {
    auto lock = RunLock::of_session(options.session, operator_name(), MachineClock().read().wall);
    if (!lock) return bad_input(lock.error().message);
    held.emplace(std::move(*lock));
  }
  Terminal terminal(Terminal::Style::plain);
  const auto session = read_for(terminal, options.session, options.reading);
  if (!session) return bad_input(session.error().message);
  const auto bundle = interlaboratory::make_bundle(*session, options.out, STROBE_VERSION);
  if (!bundle) return failed(bundle.error().message);
  for (const std::string& line : bundle->left_out) terminal.note(options.session + ": " + line);
  print({fmt::format("{}: {} shots, {} files", options.out, session->shots.size(), bundle->files),
         "manifest's SHA-256: " + bundle->manifest_sha256});
  return kDone;
}

/// The folder to unpack into, beneath what goes when it is not asked for.
Result<fs::path> folder_for(const BundleOptions& options, std::optional<external::WorkFolder>& work) {
  std::error_code error;
  if (!options.into.empty()) {
    if (fs::exists(options.into, error) && !fs::is_empty(options.into, error))
      return fail("--into " + options.into + ": is not empty");
    fs::create_directories(options.into, error);
    if (error) return fail("--into " + options.into + ": " + error.message());
    return fs::path(options.into);
  }
  auto made = external::WorkFolder::make(fs::temp_directory_path(error));
  if (!made) return tl::unexpected(made.error());
  work.emplace(std::move(*made));
  return work->path();
}

int look_at(const BundleOptions& options) {
  std::optional<external::WorkFolder> work;
  const auto folder = folder_for(options, work);
  if (!folder) return bad_input("bundle: " + folder.error().message);
  const auto check = interlaboratory::check_bundle(options.check, *folder,
                                                   {options.reading.rig_path, options.reading.key_file, {}});
  if (!check) return bad_input(check.error().message);
  for (const std::string& remark : check->remarks) std::fprintf(stderr, "strobe: %s\n", remark.c_str());
  print({fmt::format("{}: session {}, by strobe {}", options.check, check->session, check->version),
         "manifest's SHA-256: " + check->manifest_sha256});
  if (!check->problems.empty() && check->version != STROBE_VERSION)
    print(
        {fmt::format("computed again by strobe {}: other versions may give other numbers", STROBE_VERSION)});
  for (const std::string& problem : check->problems) print({"! " + problem});
  if (!check->problems.empty()) return kFailed;
  print({fmt::format("{} files: as they were handed over", check->files),
         fmt::format("{} shots, {} counted: computed again, the same bytes", check->shots, check->counted)});
  if (!check->outcome.empty()) print({check->outcome});
  return kDone;
}

int run_bundle(const BundleOptions& options) {
  if (options.session.empty() == options.check.empty())
    return bad_input("bundle: give a session's folder, or --check FILE.tar");
  return options.check.empty() ? hand_over(options) : look_at(options);
}

}  // namespace

void add_bundle_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<BundleOptions>();
  CLI::App* command = app.add_subcommand("bundle", "A session as one file for others, who compute it again");
  command->add_option("SESSION", options->session, "a session's folder: all its files but keys");
  command->add_option("--out", options->out, "file to write, a tar")->type_name("FILE.tar");
  command
      ->add_option("--check", options->check,
                   "in place of a session: verifies each file of a bundle by its hash, and computes its "
                   "results again")
      ->type_name("FILE.tar");
  command->add_option("--into", options->into, "of --check: unpack here, and leave it there")
      ->type_name("DIR");
  add_session_options(*command, options->reading);
  command_line::for_experts(*command, {"--rig", "--key-file"});
  command->footer(
      "Examples: strobe bundle sessions/today --out today.tar\n"
      "          strobe bundle --check today.tar\n"
      "Exit status: 1 if a file is not what was handed over, or results differ.");
  command->callback([options, &exit_status] { exit_status = run_bundle(*options); });
}

}  // namespace strobe::host
