#include "host/drivers/gphoto2/gphoto_camera.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string_view>

namespace strobe::gphoto2 {

namespace {

namespace fs = std::filesystem;

/// Of names and values.
class List {
 public:
  List() { gp_list_new(&list_); }
  ~List() { gp_list_free(list_); }
  List(const List&) = delete;
  List& operator=(const List&) = delete;

  CameraList* get() const { return list_; }
  int size() const { return gp_list_count(list_); }
  std::string name(int i) const {
    const char* text = nullptr;
    return gp_list_get_name(list_, i, &text) >= GP_OK && text != nullptr ? text : "";
  }
  std::string value(int i) const {
    const char* text = nullptr;
    return gp_list_get_value(list_, i, &text) >= GP_OK && text != nullptr ? text : "";
  }

 private:
  CameraList* list_ = nullptr;
};

tl::unexpected<Error> failed(const std::string& what, int result) {
  return fail(fmt::format("{}: {}", what, gp_result_as_string(result)));
}

Result<void> set_port(Camera* camera, const std::string& address) {
  GPPortInfoList* ports = nullptr;
  gp_port_info_list_new(&ports);
  int result = gp_port_info_list_load(ports);
  const int port = result < GP_OK ? result : gp_port_info_list_lookup_path(ports, address.c_str());
  GPPortInfo info{};
  result = port < GP_OK ? port : gp_port_info_list_get_info(ports, port, &info);
  if (result >= GP_OK) result = gp_camera_set_port_info(camera, info);
  gp_port_info_list_free(ports);
  if (result < GP_OK) return failed(address, result);
  return {};
}

/// Where libgphoto2 does not find out itself which of its drivers a port needs.
const char* model_of(const std::string& address) {
  if (address.starts_with("ptpip:")) return "PTP/IP Camera";
  return address.starts_with("disk:") ? "Directory Browse" : nullptr;
}

Result<void> set_model(Camera* camera, GPContext* context, const char* model) {
  CameraAbilitiesList* all = nullptr;
  gp_abilities_list_new(&all);
  int result = gp_abilities_list_load(all, context);
  if (result >= GP_OK) result = gp_abilities_list_lookup_model(all, model);
  CameraAbilities abilities{};
  if (result >= GP_OK) result = gp_abilities_list_get_abilities(all, result, &abilities);
  if (result >= GP_OK) result = gp_camera_set_abilities(camera, abilities);
  gp_abilities_list_free(all);
  if (result < GP_OK) return failed(model, result);
  return {};
}

/// 100NIKON: three digits, five letters or digits (CIPA DC-009).
bool is_numbered(const std::string& folder) {
  const std::string name = folder.substr(folder.rfind('/') + 1);
  return name.size() == 8 &&
         std::all_of(name.begin(), name.begin() + 3, [](unsigned char c) { return std::isdigit(c) != 0; });
}

std::string join(const std::string& folder, const std::string& name) {
  return (folder == "/" ? "" : folder) + "/" + name;
}

CameraEvent::Kind kind_of_text(const char* text) {
  const std::string_view words = text == nullptr ? "" : text;
  constexpr std::string_view kStoreFull = "PTP Event 400a";
  if (words.starts_with(kStoreFull)) return CameraEvent::Kind::card_full;
  return words.find("Property") == std::string_view::npos ? CameraEvent::Kind::other
                                                          : CameraEvent::Kind::setting_changed;
}

}  // namespace

Result<std::vector<tether::CameraIdentity>> GphotoCamera::list() {
  const List found;
  GPContext* context = gp_context_new();
  const int result = gp_camera_autodetect(found.get(), context);
  gp_context_unref(context);
  if (result < GP_OK) return failed("cameras cannot be looked for", result);
  std::vector<tether::CameraIdentity> cameras;
  for (int i = 0; i < found.size(); ++i) {
    tether::CameraIdentity camera;
    camera.model = found.name(i);
    camera.address = found.value(i);
    cameras.push_back(std::move(camera));
  }
  return cameras;
}

Result<std::unique_ptr<GphotoCamera>> GphotoCamera::open_port(const std::string& address) {
  std::unique_ptr<GphotoCamera> opened(new GphotoCamera);
  opened->context_ = gp_context_new();
  int result = gp_camera_new(&opened->camera_);
  if (result < GP_OK) return failed("libgphoto2", result);
  if (const auto set = set_port(opened->camera_, address); !set) return tl::unexpected(set.error());
  if (const char* model = model_of(address); model != nullptr) {
    if (const auto set = set_model(opened->camera_, opened->context_, model); !set)
      return tl::unexpected(set.error());
  }
  result = gp_camera_init(opened->camera_, opened->context_);
  if (result < GP_OK) return failed(address, result);
  opened->identify(address);
  return opened;
}

Result<std::unique_ptr<GphotoCamera>> GphotoCamera::open(const std::string& address,
                                                         const std::string& serial) {
  std::vector<tether::CameraIdentity> candidates(1);
  candidates[0].address = address;
  if (address.empty()) {
    auto found = list();
    if (!found) return tl::unexpected(found.error());
    candidates = std::move(*found);
  }
  if (candidates.empty()) return fail("no camera is found on USB: is it switched on, awake, set to PTP?");
  if (serial.empty() && candidates.size() > 1)
    return fail(fmt::format("{} cameras are found: serial or address must say which", candidates.size()));
  std::string others;
  for (const tether::CameraIdentity& candidate : candidates) {
    auto opened = open_port(candidate.address);
    if (!opened && candidates.size() == 1) return opened;
    if (opened && (serial.empty() || (*opened)->identity().serial == serial)) return opened;
    others += fmt::format("{}{} is {}", others.empty() ? "" : ", ", candidate.address,
                          opened ? (*opened)->identity().serial : opened.error().message);
  }
  return fail(fmt::format("no camera has the serial number {}: {}", serial, others));
}

GphotoCamera::~GphotoCamera() {
  if (camera_ != nullptr) {
    gp_camera_exit(camera_, context_);
    gp_camera_unref(camera_);
    // libgphoto2 2.5.30 closes descriptor 0 with a PTP/IP camera; no other is to get that number.
    if (fcntl(STDIN_FILENO, F_GETFD) < 0) ::open("/dev/null", O_RDONLY);
  }
  if (context_ != nullptr) gp_context_unref(context_);
}

void GphotoCamera::identify(const std::string& address) {
  CameraAbilities abilities{};
  gp_camera_get_abilities(camera_, &abilities);
  const Config config = this->config().value_or(Config{});
  const auto of = [&config](const char* name) {
    const auto found = config.find(name);
    return found == config.end() ? std::string() : found->second.value;
  };
  identity_.address = address;
  identity_.vendor = of("manufacturer");
  identity_.model = of("cameramodel").empty() ? std::string(abilities.model) : of("cameramodel");
  identity_.serial = of("eosserialnumber").empty() ? of("serialnumber") : of("eosserialnumber");
  identity_.firmware = of("deviceversion");
}

bool GphotoCamera::answers() {
  CameraStorageInformation* storage = nullptr;
  int count = 0;
  const int result = gp_camera_get_storageinfo(camera_, &storage, &count, context_);
  std::free(storage);
  return result >= GP_OK || result == GP_ERROR_CAMERA_BUSY || result == GP_ERROR_NOT_SUPPORTED;
}

std::optional<std::uint64_t> GphotoCamera::free_bytes() {
  CameraStorageInformation* storage = nullptr;
  int count = 0;
  if (gp_camera_get_storageinfo(camera_, &storage, &count, context_) < GP_OK) return std::nullopt;
  std::optional<std::uint64_t> bytes;
  for (int i = 0; i < count; ++i) {
    if ((storage[i].fields & GP_STORAGEINFO_FREESPACEKBYTES) != 0)
      bytes = bytes.value_or(0) + 1024 * storage[i].freekbytes;
  }
  std::free(storage);
  return bytes;
}

Result<CameraEvent> GphotoCamera::wait_for_event(std::chrono::milliseconds longest) {
  CameraEventType type = GP_EVENT_TIMEOUT;
  void* data = nullptr;
  const int result =
      gp_camera_wait_for_event(camera_, static_cast<int>(longest.count()), &type, &data, context_);
  if (result == GP_ERROR_NOT_SUPPORTED) return CameraEvent{CameraEvent::Kind::unsupported};
  if (result < GP_OK) return fail(gp_result_as_string(result));
  CameraEvent event;
  if (type == GP_EVENT_CAPTURE_COMPLETE) event.kind = CameraEvent::Kind::capture_complete;
  if (type == GP_EVENT_FOLDER_ADDED || type == GP_EVENT_FILE_CHANGED) event.kind = CameraEvent::Kind::other;
  if (type == GP_EVENT_UNKNOWN) event.kind = kind_of_text(static_cast<const char*>(data));
  if (type == GP_EVENT_FILE_ADDED && data != nullptr) {
    const auto* path = static_cast<const CameraFilePath*>(data);
    event = {CameraEvent::Kind::file_added, {path->folder, path->name}};
  }
  std::free(data);
  return event;
}

Result<CardFile> GphotoCamera::capture() {
  CameraFilePath path{};
  const int result = gp_camera_capture(camera_, GP_CAPTURE_IMAGE, &path, context_);
  if (result < GP_OK) return fail(gp_result_as_string(result));
  return CardFile{path.folder, path.name};
}

Result<std::vector<std::string>> GphotoCamera::folders() {
  gp_filesystem_reset(camera_->fs);  // it remembers what was there
  std::vector<std::string> all{"/"};
  for (std::size_t i = 0; i < all.size(); ++i) {
    const List found;
    const int result = gp_camera_folder_list_folders(camera_, all[i].c_str(), found.get(), context_);
    if (result < GP_OK) return failed(all[i], result);
    for (int j = 0; j < found.size(); ++j) all.push_back(join(all[i], found.name(j)));
  }
  return all;
}

Result<std::string> GphotoCamera::last_folder() {
  const auto all = folders();
  if (!all) return tl::unexpected(all.error());
  std::string last;
  for (const std::string& folder : *all) {
    if (is_numbered(folder)) last = std::max(last, folder);
  }
  return last;
}

Result<std::vector<CardFile>> GphotoCamera::files(const std::string& first_folder) {
  const auto all = folders();
  if (!all) return tl::unexpected(all.error());
  std::vector<CardFile> files;
  for (const std::string& folder : *all) {
    if (is_numbered(folder) && folder < first_folder) continue;
    const List found;
    const int result = gp_camera_folder_list_files(camera_, folder.c_str(), found.get(), context_);
    if (result < GP_OK) return failed(folder, result);
    for (int i = 0; i < found.size(); ++i) files.push_back({folder, found.name(i)});
  }
  return files;
}

std::optional<std::uint64_t> GphotoCamera::size(const CardFile& file) {
  CameraFileInfo info{};
  const int result =
      gp_camera_file_get_info(camera_, file.folder.c_str(), file.name.c_str(), &info, context_);
  if (result < GP_OK || (info.file.fields & GP_FILE_INFO_SIZE) == 0) return std::nullopt;
  return info.file.size;
}

Result<void> GphotoCamera::save(const CardFile& file, const fs::path& path, bool flush) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (descriptor < 0) return fail(fmt::format("{}: {}", path.string(), std::strerror(errno)));
  const int to_flush = fcntl(descriptor, F_DUPFD_CLOEXEC, 0);
  CameraFile* target = nullptr;
  gp_file_new_from_fd(&target, descriptor);  // closes it
  const int result = gp_camera_file_get(camera_, file.folder.c_str(), file.name.c_str(), GP_FILE_TYPE_NORMAL,
                                        target, context_);
  gp_file_unref(target);
  const bool flushed = !flush || fsync(to_flush) == 0;
  close(to_flush);
  if (result < GP_OK) return failed(file.name, result);
  if (!flushed) return fail(fmt::format("{}: {}", path.string(), std::strerror(errno)));
  return {};
}

Result<void> GphotoCamera::remove(const CardFile& file) {
  const int result = gp_camera_file_delete(camera_, file.folder.c_str(), file.name.c_str(), context_);
  if (result < GP_OK) return failed(file.name, result);
  return {};
}

}  // namespace strobe::gphoto2
