#include <nlohmann/json.hpp>
#include <utility>

#include "common/messages/parsed_json.hpp"
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
  return json_text_response(messages::json_text(json), status);
}

Response error_response(int status, std::string_view words) {
  return json_response({{"error", words}}, status);
}

}  // namespace strobe::web
