#include "sim/gev/gev_camera.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include <fmt/format.h>

#include "sim/photograph/render.hpp"

namespace strobe::sim::gev {
namespace {

constexpr std::uint16_t kControlPort = 3956;
constexpr std::size_t kLargestCommand = 2048;
constexpr int kMaxCommands = 1000;  // between two looks at frames
constexpr Duration kIdle = milliseconds(100);
constexpr Duration kLookForExposure = milliseconds(5);
constexpr std::size_t kMaxWaiting = 8;
constexpr double kMachinesRate_bps = 1e9;

std::optional<std::uint32_t> ip_of(const std::string& address) {
  in_addr found{};
  if (inet_pton(AF_INET, address.c_str(), &found) != 1) return std::nullopt;
  return ntohl(found.s_addr);
}

sockaddr_in socket_address(std::uint32_t address, std::uint16_t port) {
  sockaddr_in socket{};
  socket.sin_family = AF_INET;
  socket.sin_addr.s_addr = htonl(address);
  socket.sin_port = htons(port);
  return socket;
}

Result<int> bound_socket(std::uint32_t address, std::uint16_t port, bool shared) {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const int on = 1;
  if (fd >= 0 && shared) setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  const sockaddr_in place = socket_address(address, port);
  if (fd >= 0 && bind(fd, reinterpret_cast<const sockaddr*>(&place), sizeof place) == 0) return fd;
  const int error = errno;
  if (fd >= 0) close(fd);
  char text[INET_ADDRSTRLEN] = "";
  inet_ntop(AF_INET, &place.sin_addr, text, sizeof text);
  return fail(fmt::format("the camera's port {} of {} cannot be used: {}", port, text, std::strerror(error)));
}

PixelFormat format_of(CameraPixels pixels) {
  switch (pixels) {
    case CameraPixels::mono8:
      return PixelFormat::mono8;
    case CameraPixels::mono12:
      return PixelFormat::mono12;
    case CameraPixels::mono16:
      return PixelFormat::mono16;
    case CameraPixels::bayer_rg12:
      return PixelFormat::bayer_rg12;
  }
  return PixelFormat::mono8;
}

DeviceSettings device_settings(const std::string& address, const Scene& scene) {
  using Hostile = CameraLinkSettings::Hostile;
  const CameraLinkSettings& link = scene.camera_link;
  DeviceSettings settings;
  settings.address = *ip_of(address);
  settings.serial = serial_of(address);
  settings.width = sensor_size(scene).width;
  settings.height = sensor_size(scene).height;
  settings.pixel_format = format_of(link.pixels);
  settings.exposure_step_us = 1e6 * link.exposure_step_s;
  settings.clock_offset_s = link.clock_offset_s;
  settings.clock_drift_ppm = link.clock_drift_ppm;
  settings.description = link.hostile == Hostile::xml ? description_that_explodes() : description();
  if (link.hostile == Hostile::payload) settings.payload_size_told = 0xfffffff0;
  return settings;
}

}  // namespace

std::string serial_of(const std::string& address) {
  return fmt::format("SIM-{:08X}", ip_of(address).value_or(0));
}

std::string address_problem(const std::string& address) {
  constexpr std::uint32_t kLoopback = 127;
  const auto ip = ip_of(address);
  return ip && *ip >> 24 == kLoopback ? "" : "must be an IPv4 address of the loopback, 127.x.y.z";
}

GevCamera::GevCamera(const Scene& scene, std::uint64_t seed, const ExposureStore& exposure_store,
                     RigClock clock)
    : scene_(scene),
      seed_(seed),
      exposure_store_(exposure_store),
      clock_(clock),
      stop_event_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      rate_bps_(scene.camera_link.rate_bps),
      draws_(seed, Purpose::camera_link, 0) {}

GevCamera::~GevCamera() {
  stop();
  for (const int fd : control_sockets_) close(fd);
  if (stream_socket_ >= 0) close(stream_socket_);
  close(stop_event_);
}

Result<std::unique_ptr<GevCamera>> GevCamera::create(const std::string& address, const Scene& scene,
                                                     std::uint64_t seed, const ExposureStore& exposure_store,
                                                     RigClock clock) {
  if (const std::string problem = address_problem(address); !problem.empty())
    return fail("the camera's address " + problem);
  const SensorSize size = sensor_size(scene);
  if (static_cast<double>(size.width) * size.height > kMaxPixels)
    return fail(fmt::format("scene {}: photographs of {} x {} px are too large", scene.name, size.width,
                            size.height));
  std::unique_ptr<GevCamera> camera(new GevCamera(scene, seed, exposure_store, clock));
  if (auto opened = camera->open_sockets(address); !opened) return tl::unexpected(opened.error());
  camera->device_.emplace(device_settings(address, scene), clock.now());
  return camera;
}

Result<void> GevCamera::open_sockets(const std::string& address) {
  const std::uint32_t own = *ip_of(address);
  struct Place {
    std::uint32_t address;
    bool shared;  ///< by the cameras of a machine
  };
  for (const Place place : {Place{own, false}, Place{0xffffffff, true}, Place{0x7fffffff, true}}) {
    const auto fd = bound_socket(place.address, kControlPort, place.shared);
    if (!fd) return tl::unexpected(fd.error());
    control_sockets_.push_back(*fd);
  }
  const auto stream = bound_socket(own, 0, false);
  if (!stream) return tl::unexpected(stream.error());
  stream_socket_ = *stream;
  return {};
}

void GevCamera::start(bool in_machines_time) {
  if (in_machines_time) rate_bps_ = std::min(rate_bps_, kMachinesRate_bps);
  thread_ = std::thread([this] { run(); });
}

void GevCamera::stop() {
  if (!thread_.joinable()) return;
  stopping_ = true;
  eventfd_write(stop_event_, 1);
  thread_.join();
}

void GevCamera::run() {
  while (!stopping_) {
    take_datagrams();
    if (away_until_) {
      come_back();
      continue;
    }
    device_->check_heartbeat(clock_.now());
    obey();
    look_for_exposures();
    expose_by_itself();
    make_frames();
    queue_resends();
    send_some();
  }
}

Duration GevCamera::until_due() const {
  const MonoTime now = clock_.now();
  MonoTime due = now + (device_->acquires() ? kLookForExposure : kIdle);
  if (away_until_) due = *away_until_;
  if (!sending_.empty()) due = std::min(due, send_at_);
  if (known(next_own_)) due = std::min(due, next_own_);
  for (const Waiting& waiting : waiting_) due = std::min(due, waiting.due);
  return std::max(Duration{}, due - now);
}

void GevCamera::take_datagrams() {
  std::array<pollfd, 4> awaited{};
  for (std::size_t i = 0; i < control_sockets_.size(); ++i) awaited[i] = {control_sockets_[i], POLLIN, 0};
  awaited.back() = {stop_event_, POLLIN, 0};
  clock_.poll(awaited.data(), awaited.size(), until_due());
  std::array<std::uint8_t, kLargestCommand> bytes;
  for (const int fd : control_sockets_) {
    for (int i = 0; i < kMaxCommands; ++i) {
      sockaddr_in from{};
      socklen_t size = sizeof from;
      const ssize_t count =
          recvfrom(fd, bytes.data(), bytes.size(), MSG_DONTWAIT, reinterpret_cast<sockaddr*>(&from), &size);
      if (count < 0) break;
      if (away_until_) continue;
      const auto answer = device_->answer({bytes.data(), static_cast<std::size_t>(count)},
                                          {ntohl(from.sin_addr.s_addr), ntohs(from.sin_port)}, clock_.now());
      // Whatever socket was asked: the answer comes from the camera's address.
      if (answer)
        sendto(control_sockets_.front(), answer->data(), answer->size(), MSG_DONTWAIT,
               reinterpret_cast<const sockaddr*>(&from), size);
    }
  }
}

void GevCamera::obey() {
  if (device_->take_stream_opened()) block_ = 0;
  if (device_->take_test_packet()) send_test_packet();
  const bool triggered = device_->word(camera::kTriggerMode) != 0;
  const bool by_software = triggered && device_->word(camera::kTriggerSource) != 0;
  const int triggers = device_->take_software_triggers();
  const MonoTime now = clock_.now();
  const Duration exposure = from_seconds(1e-6 * device_->number(camera::kExposureTime));
  const Duration readout = from_seconds(scene_.camera_link.readout_s);
  if (device_->acquires() && by_software && triggers > 0 && waiting_.size() < kMaxWaiting)
    waiting_.push_back({nullptr, now, now + exposure + readout});
  if (!device_->acquires() || triggered) {
    next_own_ = kNoTime;
  } else if (!known(next_own_)) {
    next_own_ = now;
  }
}

void GevCamera::expose_by_itself() {
  const MonoTime now = clock_.now();
  if (!known(next_own_) || now < next_own_ || waiting_.size() >= kMaxWaiting) return;
  const Duration exposure = from_seconds(1e-6 * device_->number(camera::kExposureTime));
  waiting_.push_back({nullptr, now, now + exposure + from_seconds(scene_.camera_link.readout_s)});
  next_own_ = now + std::max(exposure, from_seconds(1.0 / device_->number(camera::kFrameRate)));
}

bool GevCamera::exposes(const Exposure& exposure) const {
  return device_->acquires() && device_->word(camera::kTriggerMode) != 0 &&
         device_->word(camera::kTriggerSource) == 0 && known(exposure.opened) &&
         exposure.opened >= *device_->acquires_since() &&
         shot_fault(scene_.faults, FaultKind::no_photograph, exposure.shot) == nullptr;
}

void GevCamera::look_for_exposures() {
  const auto exposures = exposure_store_.all();
  for (; seen_ < exposures.size(); ++seen_) take_exposure(exposures[seen_]);
}

void GevCamera::take_exposure(const std::shared_ptr<const Exposure>& exposure) {
  if (const Fault* gone = shot_fault(scene_.faults, FaultKind::camera_vanishes, exposure->shot))
    return vanish(gone->delay);
  if (!exposes(*exposure)) return;
  Exposure seen = *exposure;
  if (device_->word(camera::kExposureMode) == 0)
    seen.closed = seen.opened + from_seconds(1e-6 * device_->number(camera::kExposureTime));
  const Fault* late = shot_fault(scene_.faults, FaultKind::frame_late, seen.shot);
  const MonoTime due =
      seen.closed + from_seconds(scene_.camera_link.readout_s) + (late != nullptr ? late->delay : Duration{});
  waiting_.push_back({std::make_shared<const Exposure>(seen), seen.opened, due});
}

void GevCamera::vanish(Duration duration) {
  away_until_ = clock_.now() + duration;
  waiting_.clear();
  sending_.clear();
  kept_.clear();
  next_own_ = kNoTime;
}

void GevCamera::come_back() {
  if (clock_.now() < *away_until_) return;
  away_until_.reset();
  seen_ = exposure_store_.all().size();
  block_ = 0;
  device_->power_up(clock_.now());
}

}  // namespace strobe::sim::gev
