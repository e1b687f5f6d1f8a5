// Where a lab's key is kept, and whether it is kept well. The one part of common/ that reads files: firmware
// and host must judge a secret's rights alike. At start only; reads the environment; one thread.
#pragma once

#include <filesystem>
#include <string>

#include "common/authentication/key.hpp"

namespace strobe::authentication {

/// What command line and rig file say; empty: nothing.
struct KeyPlaces {
  std::string option;    ///< --key-file
  std::string rig_file;  ///< [commands] key_file, already beside its rig file
};

struct FoundKey {
  Key key;
  std::filesystem::path path;
  bool made = false;  ///< it was not there before
};

/// The first of: the option's file, the rig file's, $STROBE_KEY_FILE, $CREDENTIALS_DIRECTORY/lab.key
/// (systemd's LoadCredential=) if there is one, and $XDG_CONFIG_HOME/strobe/lab.key (or in ~/.config), which
/// is made if it is not there, so that firmware and host of one user on one machine need no set-up. Fails
/// with one line that names the file and what to do.
Result<FoundKey> find_key(const KeyPlaces& places);

/// Makes a key file that only this user can read, in folders made if need be. Of several programs that do so
/// at once one wins, and no file is ever seen half written. Fails if there is one already.
Result<FoundKey> make_key_file(const std::filesystem::path& path);

/// Fails unless it is a regular file of this user's that nobody else can read or change, with a key in it. A
/// symbolic link is as good as what it points to.
Result<Key> read_key_file(const std::filesystem::path& path);

}  // namespace strobe::authentication
