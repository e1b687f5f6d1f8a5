// Another program, run to its end in a temporary folder beside its results. Starts processes, writes files;
// thread-safe.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "common/units/time.hpp"

namespace strobe::external {

/// Searched in $PATH. Returns nullopt if it is not there.
std::optional<std::filesystem::path> find_program(const std::string& name);

/// One of this project's own that users do not type: beside this program, or in ../libexec/strobe. Returns
/// nullopt if it is not installed.
std::optional<std::filesystem::path> find_own_program(const std::string& name);

/// A folder that goes when the object does, with all that is in it.
class WorkFolder {
 public:
  /// In `folder`, which is made if it is missing: what is finished here can be renamed into it.
  static Result<WorkFolder> make(const std::filesystem::path& folder);
  WorkFolder(WorkFolder&& other) noexcept;
  WorkFolder& operator=(WorkFolder&&) = delete;
  ~WorkFolder();

  /// Absolute.
  const std::filesystem::path& path() const { return path_; }
  /// The last line that a program run here has written; "no message" if there is none.
  std::string last_message() const;

 private:
  explicit WorkFolder(std::filesystem::path path) : path_(std::move(path)) {}
  std::filesystem::path path_;
};

/// Runs words[0] with the others as its arguments, in the folder, without input. environment: "NAME=value",
/// beside or in place of this process's. longest: by then it is ended. Fails with one line: the program, and
/// its last message where it did not exit with 0.
Result<void> run_program(std::vector<std::string> words, const WorkFolder& folder,
                         std::vector<std::string> environment = {},
                         std::optional<Duration> longest = std::nullopt);

}  // namespace strobe::external
