// Where a lab's key is kept, and whether only its owner can read it. It reads files, as firmware and host
// must check a secret's permissions alike. At start only; reads the environment; one thread's.
#pragma once

#include <filesystem>
#include <string>

#include "common/authentication/key.hpp"

namespace strobe::authentication {

/// From command line and rig file; empty if not given.
struct KeyPlaces {
  std::string option;    ///< --key-file
  std::string rig_file;  ///< [commands] key_file, already beside its rig file
};

struct FoundKey {
  Key key;
  std::filesystem::path path;
  bool made = false;  ///< it did not exist before
};

/// The first of: the option's file, the rig file's, $STROBE_KEY_FILE, $CREDENTIALS_DIRECTORY/lab.key
/// (systemd's LoadCredential=) if there is one, in a folder that this user must be able to look into, and
/// $XDG_CONFIG_HOME/strobe/lab.key (or in ~/.config), which is created if it does not exist, so that firmware
/// and host of one user on one machine need no set-up. Fails with one line that names the file and what to
/// do.
Result<FoundKey> find_key(const KeyPlaces& places);

/// Creates a key file that only this user can read, and its folders, in which others may look. If several
/// programs do so at once one succeeds, and no other program sees a half-written file. Fails if the file
/// exists.
Result<FoundKey> make_key_file(const std::filesystem::path& path);

/// Fails unless it is a regular file, owned by this user, that nobody else can read or change, and holds a
/// key. Symbolic links are followed.
Result<Key> read_key_file(const std::filesystem::path& path);

}  // namespace strobe::authentication
