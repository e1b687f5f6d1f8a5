#include "host/web/http/gate.hpp"

#include <utility>

#include "host/web/http/target.hpp"

namespace strobe::web {

std::variant<Response, Welcome, Admitted> Gate::on_head(const RequestHead& head) const {
  if (auto cookie = access_.cookie_for(head)) return Welcome{std::move(*cookie)};
  if (const auto refused = access_.check(head)) return error_response(refused->status, refused->words);
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
    admitted.file = files_.find(admitted.request.path);
    if (admitted.file && reads) return admitted;
    if (admitted.file) admitted.found.status = 405;
  }
  return Router::answer(admitted.found, admitted.request);
}

}  // namespace strobe::web
