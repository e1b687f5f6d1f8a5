#include <CLI/CLI.hpp>

#include <cstdio>
#include <memory>

#include "common/authentication/key_file.hpp"
#include "host/commands/command.hpp"
#include "host/config/rig_file.hpp"

namespace strobe::host {
namespace {

struct KeyOptions {
  std::string rig_path, key_file, new_file;
};

Result<authentication::FoundKey> found(const KeyOptions& options) {
  if (!options.new_file.empty()) return authentication::make_key_file(options.new_file);
  const auto rig = load_rig(options.rig_path);
  if (!rig) return tl::unexpected(rig.error());
  return authentication::find_key({options.key_file, rig->key_file.value_or("")});
}

int run(const KeyOptions& options) {
  const auto key = found(options);
  if (!key) return bad_input(key.error().message);
  std::printf("%s  fingerprint %s%s\n", key->path.c_str(), key->key.fingerprint().c_str(),
              key->made ? "  (new)" : "");
  return kDone;
}

}  // namespace

void add_key_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<KeyOptions>();
  CLI::App* command = app.add_subcommand("key", "The lab's key: its fingerprint, or a new one");
  command->add_option("--rig", options->rig_path, "rig file (default: the example that comes with strobe)");
  command->add_option("--key-file", options->key_file,
                      "the lab's key (default: the rig file's, $STROBE_KEY_FILE, ~/.config/strobe/lab.key)");
  command->add_option("--new", options->new_file, "make a key in this new file, which only you can read");
  command->footer(
      "Example: strobe key --new lab.key\n"
      "Firmware and hosts of a lab need the same key: copy the file over a way that nobody else reads "
      "(scp keeps its rights with -p), and compare fingerprints.");
  command->callback([options, &exit_status] { exit_status = run(*options); });
}

}  // namespace strobe::host
