// What one laboratory hands over to another: a session's files as one tar with their SHA-256, which the other
// unpacks, verifies and computes again. Reads and writes files; one thread's. The archive's first name is the
// session's folder; in it MANIFEST.sha256 has a line for each other file, as sha256sum(1) reads and writes
// them, and bundle.json the version of strobe that made it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "host/archive/read_session.hpp"

namespace strobe::interlaboratory {

struct Bundle {
  std::size_t files = 0;              ///< of the session
  std::string manifest_sha256;        ///< what tells this bundle from any other
  std::vector<std::string> left_out;  ///< a sentence for each file that is not handed over
};

/// version: of strobe. The same session gives the same bytes. Keys and what is hidden are left out. Fails
/// with one line: a file that cannot be read or is a link, or results.csv is not what the session says.
Result<Bundle> make_bundle(const host::StoredSession& session, const std::filesystem::path& archive,
                           const std::string& version);

struct BundleCheck {
  std::string session;  ///< its folder's name
  std::string version;  ///< of strobe that made it; empty: not told
  std::size_t files = 0, shots = 0, counted = 0;
  std::string manifest_sha256;
  std::string outcome;  ///< of the protocol that it was fired for, as computed again, lines; empty: for none
  std::vector<std::string> remarks;   ///< what could not be read
  std::vector<std::string> problems;  ///< a sentence for each file that is missing, changed, new, or computed
                                      ///< to other bytes; none: it is as it was handed over
};

/// Unpacks into a folder, which is empty or not yet there, and looks at all of it. Fails where it is no such
/// bundle, or one that is made to do harm.
Result<BundleCheck> check_bundle(const std::filesystem::path& archive, const std::filesystem::path& into,
                                 const host::ReadSessionOptions& reading);

}  // namespace strobe::interlaboratory
