#include <nlohmann/json.hpp>
#include <utility>

#include "host/web/http/request.hpp"

namespace strobe::web {

using nlohmann::ordered_json;

Response json_text_response(std::string json, int status) {
  Response response;
  response.status = status;
  response.body = std::make_shared<const std::string>(std::move(json));
  return response;
}

Response json_response(const ordered_json& json, int status) {
  return json_text_response(json.dump(-1, ' ', false, ordered_json::error_handler_t::replace), status);
}

Response error_response(int status, std::string_view words) {
  return json_response({{"error", words}}, status);
}

}  // namespace strobe::web
