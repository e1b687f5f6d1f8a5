#include "host/drivers/genicam/camera.hpp"

#include <arv.h>
#include <fmt/format.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <charconv>

namespace strobe::genicam {
namespace {

class GlibError {
 public:
  GlibError() = default;
  ~GlibError() { g_clear_error(&error_); }
  GlibError(const GlibError&) = delete;
  GlibError& operator=(const GlibError&) = delete;
  GError** out() { return &error_; }
  explicit operator bool() const { return error_ != nullptr; }
  /// On one line.
  std::string words() const {
    std::string words = error_ != nullptr && error_->message != nullptr ? error_->message : "no reason given";
    std::ranges::replace_if(
        words, [](unsigned char c) { return c < ' '; }, ' ');
    return words;
  }

 private:
  GError* error_ = nullptr;
};

std::string text_of(const char* text) { return text != nullptr ? text : ""; }

template <typename Value>
Result<Value> value_or(Value value, const std::string& name, const GlibError& error) {
  if (error) return fail(fmt::format("{}: {}", name, error.words()));
  return value;
}

Result<void> done_or(const std::string& name, const GlibError& error) {
  if (error) return fail(fmt::format("{}: {}", name, error.words()));
  return {};
}

template <typename Number>
std::optional<Number> parsed(const std::string& text) {
  Number number{};
  const char* end = text.data() + text.size();
  const auto [at, fault] = std::from_chars(text.data(), end, number);
  if (fault != std::errc{} || at != end) return std::nullopt;
  return number;
}

/// As people write it; GenICam's own are true and false.
std::optional<bool> parsed_boolean(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::tolower(c); });
  if (text == "true" || text == "1" || text == "on") return true;
  if (text == "false" || text == "0" || text == "off") return false;
  return std::nullopt;
}

}  // namespace

std::vector<tether::CameraIdentity> list_cameras() {
  arv_update_device_list();
  std::vector<tether::CameraIdentity> cameras;
  for (unsigned i = 0; i < arv_get_n_devices(); ++i)
    cameras.push_back({text_of(arv_get_device_vendor(i)), text_of(arv_get_device_model(i)),
                       text_of(arv_get_device_serial_nbr(i)), "", text_of(arv_get_device_address(i))});
  return cameras;
}

/// Outlives the camera, as Aravis' thread may be about to tell it.
struct Camera::Loss {
  std::atomic<bool> lost = false;
  int event = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  ~Loss() {
    if (event >= 0) close(event);
  }
  static void tell(ArvDevice*, gpointer data) {
    Loss& loss = **static_cast<std::shared_ptr<Loss>*>(data);
    loss.lost = true;
    const std::uint64_t one = 1;
    static_cast<void>(!write(loss.event, &one, sizeof one));
  }
  static void forget(gpointer data, GClosure*) { delete static_cast<std::shared_ptr<Loss>*>(data); }
};

Camera::Camera(ArvCamera* camera) : loss_(std::make_shared<Loss>()), camera_(camera) {
  arv_camera_set_register_cache_policy(camera, ARV_REGISTER_CACHE_POLICY_DISABLE);
  arv_camera_set_range_check_policy(camera, ARV_RANGE_CHECK_POLICY_DISABLE);
  g_signal_connect_data(device(), "control-lost", G_CALLBACK(Loss::tell), new std::shared_ptr<Loss>(loss_),
                        Loss::forget, GConnectFlags{});
  const auto any = [this](std::initializer_list<const char*> names) {
    for (const char* name : names) {
      if (const auto text = get(name); text && !text->empty()) return *text;
    }
    return std::string();
  };
  identity_ = {any({"DeviceVendorName"}), any({"DeviceModelName"}),
               any({"DeviceSerialNumber", "DeviceID", "DeviceUserID"}),
               any({"DeviceFirmwareVersion", "DeviceVersion"}), ""};
}

Camera::~Camera() = default;

Result<std::unique_ptr<Camera>> Camera::open(const std::string& address) {
  GlibError error;
  ArvCamera* aravis = arv_camera_new(address.c_str(), error.out());
  if (aravis == nullptr) return fail(fmt::format("{}: {}", address, error.words()));
  std::unique_ptr<Camera> camera(new Camera(aravis));
  if (camera->is_gige() && !arv_gv_device_is_controller(ARV_GV_DEVICE(camera->device())))
    return fail(fmt::format("{}: another program controls the camera", address));
  if (camera->is_gige())
    arv_camera_gv_set_stream_options(aravis, ARV_GV_STREAM_OPTION_PACKET_SOCKET_DISABLED);
  camera->identity_.address = address;
  return camera;
}

ArvDevice* Camera::device() const { return arv_camera_get_device(camera_.get()); }

bool Camera::is_gige() const { return arv_camera_is_gv_device(camera_.get()); }

ArvGcNode* Camera::node(const std::string& name) const {
  ArvGcNode* found = arv_device_get_feature(device(), name.c_str());
  return ARV_IS_GC_FEATURE_NODE(found) ? found : nullptr;
}

Kind Camera::kind(const std::string& name) const {
  ArvGcNode* found = node(name);
  GlibError error;
  if (found == nullptr || !arv_gc_feature_node_is_available(ARV_GC_FEATURE_NODE(found), error.out()) || error)
    return Kind::absent;
  if (ARV_IS_GC_ENUMERATION(found)) return Kind::enumeration;
  if (ARV_IS_GC_COMMAND(found)) return Kind::command;
  if (ARV_IS_GC_BOOLEAN(found)) return Kind::boolean;
  if (ARV_IS_GC_INTEGER(found)) return Kind::integer;
  if (ARV_IS_GC_FLOAT(found)) return Kind::number;
  return ARV_IS_GC_STRING(found) ? Kind::text : Kind::absent;
}

Result<std::string> Camera::get(const std::string& name) const {
  GlibError error;
  switch (kind(name)) {
    case Kind::enumeration:
    case Kind::text:
      return value_or(text_of(arv_device_get_string_feature_value(device(), name.c_str(), error.out())), name,
                      error);
    case Kind::boolean:
      return value_or(
          std::string(arv_device_get_boolean_feature_value(device(), name.c_str(), error.out()) ? "true"
                                                                                                : "false"),
          name, error);
    case Kind::integer:
      return value_or(
          fmt::to_string(arv_device_get_integer_feature_value(device(), name.c_str(), error.out())), name,
          error);
    case Kind::number:
      return value_or(fmt::to_string(arv_device_get_float_feature_value(device(), name.c_str(), error.out())),
                      name, error);
    default:
      return fail(name + ": the camera has no such feature");
  }
}

Result<void> Camera::set(const std::string& name, const std::string& value) {
  GlibError error;
  switch (kind(name)) {
    case Kind::enumeration:
    case Kind::text:
      arv_device_set_string_feature_value(device(), name.c_str(), value.c_str(), error.out());
      break;
    case Kind::boolean: {
      const auto truth = parsed_boolean(value);
      if (!truth) return fail(fmt::format("{}: \"{}\" is neither true nor false", name, value));
      arv_device_set_boolean_feature_value(device(), name.c_str(), *truth, error.out());
      break;
    }
    case Kind::integer: {
      const auto number = parsed<std::int64_t>(value);
      if (!number) return fail(fmt::format("{}: \"{}\" is no whole number", name, value));
      arv_device_set_integer_feature_value(device(), name.c_str(), *number, error.out());
      break;
    }
    case Kind::number: {
      const auto number = parsed<double>(value);
      if (!number) return fail(fmt::format("{}: \"{}\" is no number", name, value));
      arv_device_set_float_feature_value(device(), name.c_str(), *number, error.out());
      break;
    }
    case Kind::command:
      return execute(name);
    case Kind::absent:
      return fail(name + ": the camera has no such feature");
  }
  return done_or(name, error);
}

Result<void> Camera::execute(const std::string& command) {
  GlibError error;
  arv_device_execute_command(device(), command.c_str(), error.out());
  return done_or(command, error);
}

std::vector<std::string> Camera::entries(const std::string& name) const {
  if (kind(name) != Kind::enumeration) return {};
  GlibError error;
  guint count = 0;
  const char** names = arv_device_dup_available_enumeration_feature_values_as_strings(device(), name.c_str(),
                                                                                      &count, error.out());
  std::vector<std::string> entries;
  for (guint i = 0; names != nullptr && i < count; ++i) entries.push_back(text_of(names[i]));
  g_free(names);
  return entries;
}

std::optional<Range> Camera::range(const std::string& name) const {
  GlibError error;
  Range range;
  if (kind(name) == Kind::number) {
    arv_device_get_float_feature_bounds(device(), name.c_str(), &range.min, &range.max, error.out());
  } else {
    gint64 min = 0, max = 0;
    arv_device_get_integer_feature_bounds(device(), name.c_str(), &min, &max, error.out());
    range = {static_cast<double>(min), static_cast<double>(max)};
  }
  if (error || !(range.min < range.max)) return std::nullopt;
  return range;
}

std::optional<std::uint32_t> Camera::read_register(std::uint32_t address) const {
  GlibError error;
  guint32 value = 0;
  if (!arv_device_read_register(device(), address, &value, error.out()) || error) return std::nullopt;
  return value;
}

bool Camera::write_register(std::uint32_t address, std::uint32_t value) {
  GlibError error;
  return arv_device_write_register(device(), address, value, error.out()) && !error;
}

bool Camera::lost() const { return loss_->lost; }
int Camera::lost_descriptor() const { return loss_->event; }

}  // namespace strobe::genicam
