#include "host/web/http/files.hpp"

#include <array>
#include <span>
#include <utility>

#include "common/config/files.hpp"

namespace strobe::web {

/// Made at build time of host/web/page, see embed.cmake.
std::span<const EmbeddedFile> embedded_files();

namespace {

namespace fs = std::filesystem;

constexpr std::array<std::pair<std::string_view, std::string_view>, 12> kTypes{{
    {".html", "text/html; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
    {".mjs", "text/javascript; charset=utf-8"},
    {".json", "application/json"},
    {".svg", "image/svg+xml"},
    {".png", "image/png"},
    {".jpg", "image/jpeg"},
    {".ico", "image/x-icon"},
    {".woff2", "font/woff2"},
    {".webmanifest", "application/manifest+json"},
    {".txt", "text/plain; charset=utf-8"},
}};

std::string_view file_of(std::string_view path) {
  return path == "/" ? std::string_view("index.html") : path.substr(path.empty() ? 0 : 1);
}

/// The name as it stands in the folder's listing: what a path could reach besides does not matter.
std::optional<fs::path> listed(const fs::path& folder, std::string_view name) {
  std::error_code error;
  for (fs::recursive_directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    if (entry->is_regular_file(error) && entry->path().lexically_relative(folder).generic_string() == name)
      return entry->path();
  }
  return std::nullopt;
}

}  // namespace

Files::Files() {
  for (const EmbeddedFile& file : embedded_files()) {
    Response response;
    response.type = content_type_of(file.name);
    response.body = std::make_shared<const std::string>(file.content);
    response.etag = file.hash;
    built_in_.emplace(file.name, std::move(response));
  }
}

std::optional<Response> Files::find(std::string_view path) const {
  const std::string_view name = file_of(path);
  if (folder_.empty()) {
    const auto file = built_in_.find(name);
    return file == built_in_.end() ? std::nullopt : std::optional(file->second);
  }
  const auto file = listed(folder_, name);
  if (!file) return std::nullopt;
  auto content = config::read_file(file->string());
  if (!content) return std::nullopt;
  Response response;
  response.type = content_type_of(name);
  response.body = std::make_shared<const std::string>(std::move(*content));
  return response;
}

std::string content_type_of(std::string_view name) {
  for (const auto& [ending, type] : kTypes) {
    if (name.ends_with(ending)) return std::string(type);
  }
  return "application/octet-stream";
}

}  // namespace strobe::web
