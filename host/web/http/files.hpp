// The page's files: those that were built into the program, or for work on the page those of a folder.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "host/web/http/request.hpp"

namespace strobe::web {

/// One that was built in; the views live as long as the program.
struct EmbeddedFile {
  std::string_view name;  ///< "app.js", "icons/ball.svg"
  std::string_view hash;  ///< of the content
  std::string_view content;
};

class Files {
 public:
  /// Those built in.
  Files();
  /// Read anew each time; only files that lie in the folder, by their names.
  explicit Files(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// "/" is index.html. Nothing: there is no such file.
  std::optional<Response> find(std::string_view path) const;

 private:
  std::filesystem::path folder_;
  std::map<std::string, Response, std::less<>> built_in_;
};

/// "text/html; charset=utf-8" of "a.html"; of what is not known "application/octet-stream".
std::string content_type_of(std::string_view name);

}  // namespace strobe::web
