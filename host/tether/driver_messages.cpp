#include "host/tether/driver_messages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <utility>

namespace strobe::tether {
namespace {

using nlohmann::ordered_json;

constexpr std::array<std::pair<SettingState, std::string_view>, 5> kStates{{
    {SettingState::as_asked, "as_asked"},
    {SettingState::rounded, "rounded"},
    {SettingState::refused, "refused"},
    {SettingState::absent, "absent"},
    {SettingState::read, "read"},
}};

ordered_json json_of(const CameraIdentity& camera) {
  return {{"vendor", camera.vendor},
          {"model", camera.model},
          {"serial", camera.serial},
          {"firmware", camera.firmware},
          {"address", camera.address}};
}

ordered_json json_of(const Setting& setting) {
  return {{"name", setting.name},
          {"asked", setting.asked},
          {"is", setting.is},
          {"state", name(setting.state)},
          {"remark", setting.remark}};
}

void put(ordered_json& object, const std::optional<ExposureStart>& exposed) {
  if (!exposed) return;
  object["exposed_ns"] = to_ns(exposed->instant);
  object["exposed_sd_ns"] = exposed->sd.count();
}

struct ToJson {
  ordered_json operator()(const ListRequest&) const { return {{"request", "list"}}; }
  ordered_json operator()(const OpenRequest& open) const {
    return {{"request", "open"},
            {"serial", open.serial},
            {"address", open.address},
            {"exposure_by_line", open.exposure_by_line},
            {"exposure_s", open.exposure_s},
            {"set", open.set},
            {"folder", open.folder},
            {"delete_from_camera", open.delete_from_camera}};
  }
  ordered_json operator()(const SnapRequest& snap) const {
    return {{"request", "snap"}, {"exposure_s", snap.exposure_s}};
  }
  ordered_json operator()(const CheckRequest&) const { return {{"request", "check"}}; }
  ordered_json operator()(const ReadyEvent&) const { return {{"event", "ready"}}; }
  ordered_json operator()(const CamerasEvent& event) const {
    ordered_json object{{"event", "cameras"}, {"cameras", ordered_json::array()}};
    for (const CameraIdentity& camera : event.cameras) object["cameras"].push_back(json_of(camera));
    return object;
  }
  ordered_json operator()(const OpenedEvent& event) const {
    ordered_json object{{"event", "opened"},
                        {"camera", json_of(event.camera)},
                        {"exposure", event.exposure},
                        {"has_clock", event.has_clock},
                        {"settings", ordered_json::array()},
                        {"problems", ordered_json::array()}};
    for (const Setting& setting : event.settings) object["settings"].push_back(json_of(setting));
    for (const Problem& problem : event.problems)
      object["problems"].push_back({{"prevents", problem.prevents}, {"text", problem.text}});
    return object;
  }
  ordered_json operator()(const PhotographEvent& event) const {
    ordered_json object{{"event", "photograph"}, {"file", event.file}, {"number", event.number}};
    put(object, event.exposed);
    object["packets_resent"] = event.packets_resent;
    return object;
  }
  ordered_json operator()(const LostEvent& event) const {
    ordered_json object{{"event", "lost"}, {"number", event.number}};
    put(object, event.exposed);
    object["why"] = event.why;
    return object;
  }
  ordered_json operator()(const GoneEvent& event) const { return {{"event", "gone"}, {"why", event.why}}; }
  ordered_json operator()(const FailedEvent& event) const {
    return {{"event", "failed"}, {"why", event.why}};
  }
  ordered_json operator()(const NoteEvent& event) const { return {{"event", "note"}, {"text", event.text}}; }
};

/// Bytes that are no UTF-8 (a camera's texts may hold any) are replaced.
std::string text_of(const ordered_json& object) {
  return object.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

/// The fields of one line; the first that is missing or of another kind is remembered.
class Fields {
 public:
  explicit Fields(const ordered_json& object) : object_(object) {}

  template <typename Value>
  Value get(const char* key) {
    Value value{};
    read(key, value);
    return value;
  }
  double get_seconds(const char* key) {
    const auto value = get<double>(key);
    if (!(value >= 1e-6 && value <= 3600.0)) fault(key, "must be 1e-6 to 3600");
    return value;
  }
  const ordered_json& list(const char* key) {
    static const ordered_json kNone = ordered_json::array();
    const auto found = object_.find(key);
    if (found != object_.end() && found->is_array()) return *found;
    fault(key, "must be a list");
    return kNone;
  }
  std::optional<ExposureStart> exposed() {
    if (!object_.contains("exposed_ns")) return std::nullopt;
    const auto instant_ns = get<std::int64_t>("exposed_ns");
    const auto sd_ns = get<std::int64_t>("exposed_sd_ns");
    if (sd_ns <= 0) fault("exposed_sd_ns", "must be more than 0");
    return ExposureStart{from_ns<HostTime>(instant_ns), Duration{sd_ns}};
  }
  void fault(const char* key, const std::string& what) {
    if (fault_.empty()) fault_ = fmt::format("{}: {}", key, what);
  }
  const std::string& fault() const { return fault_; }

 private:
  void read(const char* key, auto& value) {
    const auto found = object_.find(key);
    if (found == object_.end()) return fault(key, "is missing");
    try {
      found->get_to(value);
    } catch (const ordered_json::exception&) {
      fault(key, "is of another kind");
    }
  }

  const ordered_json& object_;
  std::string fault_;
};

CameraIdentity read_identity(const ordered_json& object, std::string& fault) {
  Fields fields(object);
  CameraIdentity camera;
  camera.vendor = fields.get<std::string>("vendor");
  camera.model = fields.get<std::string>("model");
  camera.serial = fields.get<std::string>("serial");
  camera.firmware = fields.get<std::string>("firmware");
  camera.address = fields.get<std::string>("address");
  if (fault.empty()) fault = fields.fault();
  return camera;
}

Setting read_setting(const ordered_json& object, std::string& fault) {
  Fields fields(object);
  Setting setting;
  setting.name = fields.get<std::string>("name");
  setting.asked = fields.get<std::string>("asked");
  setting.is = fields.get<std::string>("is");
  setting.remark = fields.get<std::string>("remark");
  const auto state = fields.get<std::string>("state");
  const auto* known = std::find_if(kStates.begin(), kStates.end(),
                                   [&](const auto& candidate) { return candidate.second == state; });
  if (known != kStates.end()) {
    setting.state = known->first;
  } else {
    fields.fault("state", "is not known");
  }
  if (fault.empty()) fault = fields.fault();
  return setting;
}

Event read_opened(Fields& fields, const ordered_json& object) {
  OpenedEvent event;
  std::string fault;
  event.camera = read_identity(object.value("camera", ordered_json::object()), fault);
  event.exposure = fields.get<std::string>("exposure");
  event.has_clock = fields.get<bool>("has_clock");
  for (const ordered_json& setting : fields.list("settings"))
    event.settings.push_back(read_setting(setting, fault));
  for (const ordered_json& problem : fields.list("problems")) {
    Fields of_problem(problem);
    event.problems.push_back({of_problem.get<bool>("prevents"), of_problem.get<std::string>("text")});
    if (fault.empty()) fault = of_problem.fault();
  }
  if (!fault.empty()) fields.fault("opened", fault);
  return event;
}

std::optional<Event> read_event(const std::string& kind, Fields& fields, const ordered_json& object) {
  if (kind == "ready") return ReadyEvent{};
  if (kind == "opened") return read_opened(fields, object);
  if (kind == "gone") return GoneEvent{fields.get<std::string>("why")};
  if (kind == "failed") return FailedEvent{fields.get<std::string>("why")};
  if (kind == "note") return NoteEvent{fields.get<std::string>("text")};
  if (kind == "lost")
    return LostEvent{fields.get<std::int64_t>("number"), fields.exposed(), fields.get<std::string>("why")};
  if (kind == "photograph") {
    return PhotographEvent{fields.get<std::string>("file"), fields.get<std::int64_t>("number"),
                           fields.exposed(), fields.get<std::int64_t>("packets_resent")};
  }
  if (kind != "cameras") return std::nullopt;
  CamerasEvent event;
  std::string fault;
  for (const ordered_json& camera : fields.list("cameras"))
    event.cameras.push_back(read_identity(camera, fault));
  if (!fault.empty()) fields.fault("cameras", fault);
  return event;
}

std::optional<Request> read_request(const std::string& kind, Fields& fields) {
  if (kind == "list") return ListRequest{};
  if (kind == "check") return CheckRequest{};
  if (kind == "snap") return SnapRequest{fields.get_seconds("exposure_s")};
  if (kind != "open") return std::nullopt;
  OpenRequest open;
  open.serial = fields.get<std::string>("serial");
  open.address = fields.get<std::string>("address");
  open.exposure_by_line = fields.get<bool>("exposure_by_line");
  open.exposure_s = fields.get_seconds("exposure_s");
  open.set = fields.get<std::map<std::string, std::string>>("set");
  open.folder = fields.get<std::string>("folder");
  open.delete_from_camera = fields.get<bool>("delete_from_camera");
  return open;
}

/// key: "request" or "event", which names the kind.
template <typename Message, typename Read>
Result<Message> parse(std::string_view line, const char* key, const Read& read) {
  const ordered_json object = ordered_json::parse(line, nullptr, false);
  if (!object.is_object()) return fail("no JSON object");
  Fields fields(object);
  const auto kind = fields.get<std::string>(key);
  if (!fields.fault().empty()) return fail(fields.fault());
  std::optional<Message> message = read(kind, fields, object);
  if (!message) return fail(fmt::format("{}: {} is not known", key, text_of(kind)));
  if (!fields.fault().empty()) return fail(fmt::format("{}: {}", kind, fields.fault()));
  return std::move(*message);
}

}  // namespace

std::string to_line(const Request& request) { return text_of(std::visit(ToJson{}, request)); }
std::string to_line(const Event& event) { return text_of(std::visit(ToJson{}, event)); }

Result<Request> parse_request(std::string_view line) {
  return parse<Request>(line, "request", [](const std::string& kind, Fields& fields, const ordered_json&) {
    return read_request(kind, fields);
  });
}

Result<Event> parse_event(std::string_view line) { return parse<Event>(line, "event", read_event); }

std::string_view name(SettingState state) {
  for (const auto& [known, text] : kStates) {
    if (known == state) return text;
  }
  return "";
}

}  // namespace strobe::tether
