#include "host/web/http/gate.hpp"

#include <map>
#include <span>
#include <utility>

namespace strobe::web {

/// Made at build time of host/web/page, see embed.cmake.
std::span<const EmbeddedFile> embedded_files();

namespace {

/// What the page is made of; of other names "application/octet-stream".
std::string_view content_type_of(std::string_view name) {
  if (name.ends_with(".html")) return "text/html; charset=utf-8";
  if (name.ends_with(".css")) return "text/css; charset=utf-8";
  if (name.ends_with(".js")) return "text/javascript; charset=utf-8";
  return name.ends_with(".svg") ? "image/svg+xml" : "application/octet-stream";
}

std::map<std::string, Response, std::less<>> page_files() {
  std::map<std::string, Response, std::less<>> files;
  for (const EmbeddedFile& file : embedded_files())
    files.emplace(file.name, Response{.type = std::string(content_type_of(file.name)),
                                      .body = std::make_shared<const std::string>(file.content),
                                      .etag = std::string(file.hash)});
  return files;
}

/// "/" is index.html. Absent: there is no such file.
std::optional<Response> page_file(std::string_view path) {
  static const auto files = page_files();
  const auto file = files.find(path == "/" ? "index.html" : path.substr(path.empty() ? 0 : 1));
  return file == files.end() ? std::nullopt : std::optional(file->second);
}

}  // namespace

std::variant<Response, Admitted> Gate::on_head(const RequestHead& head) const {
  if (auto cookie = access_.cookie_for(head)) return Response{.status = 303, .cookie = std::move(*cookie)};
  if (auto refused = access_.check(head)) return std::move(*refused);
  auto target = parse_target(head.target);
  if (!target) return error_response(400, target.error().message);
  Admitted admitted;
  admitted.request.method = head.method;
  admitted.request.path = std::move(target->path);
  admitted.request.query = std::move(target->query);
  const bool reads = head.method != "POST";
  if (admitted.request.path == kEventsPath) {
    if (head.method != "GET") return error_response(405, "not with this method");
    admitted.events = true;
    return admitted;
  }
  admitted.found = router_.find(admitted.request);
  if (admitted.found.status == 200) return admitted;
  if (admitted.found.status == 404) {
    admitted.file = page_file(admitted.request.path);
    if (admitted.file && reads) return admitted;
    if (admitted.file) admitted.found.status = 405;
  }
  return Router::answer(admitted.found, admitted.request);
}

}  // namespace strobe::web
