// A session's folder digitizations/: photographs that were measured again, by a person's corrections or because their
// measurement was lost. shot-0003-<boot hex>-<n>.json holds the frame as `strobe digitize --json` prints it, with who
// and when; the corrections that made it are beside it, shot-0003-<boot hex>-<n>.toml. The largest n counts. What was
// taken back has another ending. Reads and writes files; one process's at a time.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"
#include "common/shot/shot_key.hpp"
#include "host/archive/stored_session.hpp"

namespace strobe::host {

struct DigitizationFile {
  std::filesystem::path path;
  ShotKey key;
  int number = 0;  ///< 1, 2, 3 ... for one shot
};

/// Absent: it is not the name of such a file.
std::optional<DigitizationFile> digitization_file(const std::filesystem::path& path);
/// Those of the session, each shot's in the order of their numbers. Fails where the folder is there and cannot be read.
Result<std::map<ShotKey, std::vector<DigitizationFile>>> digitization_files(
    const std::filesystem::path& session);
/// The name that the shot's digitization of this number has in the session, without its ending.
std::filesystem::path digitization_stem(const std::filesystem::path& session, const ShotKey& key, int number);

/// Any text. Fails with "NAME: what is wrong".
Result<Digitization> parse_digitization(std::string_view text, const ShotKey& key, const std::string& name);
/// Fails with the file's name.
Result<Digitization> read_digitization(const DigitizationFile& file);

}  // namespace strobe::host
