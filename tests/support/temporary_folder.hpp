// A folder that lives as long as the object. std::runtime_error if it cannot be made.
#pragma once

#include <filesystem>
#include <string>

namespace strobe::testing {

class TemporaryFolder {
 public:
  TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  /// Removes the folder with all that is in it, unless STROBE_KEEP_FOLDERS is set (to look at logs after a
  /// failure).
  ~TemporaryFolder();

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::filesystem::path& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

/// Writes a text file. std::runtime_error if that fails.
void write_text(const std::filesystem::path& path, const std::string& text);

/// A whole file; empty if there is none.
std::string read_text(const std::filesystem::path& path);

}  // namespace strobe::testing
