#include "sim/gev/device.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

namespace strobe::sim::gev {
namespace {

using namespace bootstrap;

constexpr std::uint32_t kWritesOfControl = 0x3;  ///< exclusive and control access, no switch-over
constexpr std::uint32_t kExclusive = 0x1;
constexpr std::uint32_t kLatch = 2, kReset = 1;
constexpr std::uint32_t kFireTestPacket = 1U << 31;
constexpr std::uint32_t kPacketSizeMask = 0xffff;
constexpr std::uint32_t kTextsEnd = kFirstUrl;
constexpr std::uint32_t kUsualPacketSize = 1500;
constexpr std::uint32_t kUsualHeartbeat_ms = 3000;

bool holds(const Feature& feature, std::uint32_t address) {
  return feature.writable && address >= feature.address && address < feature.address + feature.size;
}

int bytes_per_pixel(PixelFormat format) { return format == PixelFormat::mono8 ? 1 : 2; }

}  // namespace

Device::Device(const DeviceSettings& settings, MonoTime now) : settings_(settings) {
  settings_.description.resize((settings_.description.size() + 3) / 4 * 4, '\n');
  power_up(now);
}

void Device::power_up(MonoTime now) {
  powered_ = now;
  clock_start_ns_ = std::llround(settings_.clock_offset_s * 1e9);
  release_control();
  own_.fill(0);
  set_bootstrap();
  const auto width = static_cast<std::uint32_t>(settings_.width);
  const auto height = static_cast<std::uint32_t>(settings_.height);
  set_word(camera::kSensorWidth, width);
  set_word(camera::kSensorHeight, height);
  set_word(camera::kWidth, width);
  set_word(camera::kHeight, height);
  set_word(camera::kPixelFormat, static_cast<std::uint32_t>(settings_.pixel_format));
  set_payload_size();
  set_number(camera::kFrameRate, 5.0);
  set_number(camera::kExposureTime, 10'000.0);
  set_word(camera::kExposureAuto, 1);  // as cameras come
  set_word(camera::kGainAuto, 1);
  set_number(camera::kBlackLevel, 20.0);
  set_number(camera::kGamma, 0.45);
  set_number(camera::kTemperature, 41.5);
}

void Device::set_bootstrap() {
  bootstrap_.fill(0);
  set_word(kVersion, 0x00010002);
  set_word(kDeviceMode, 0x80000001);  // big-endian, UTF-8
  set_word(kMacHigh, 0x0200);         // locally administered
  set_word(kMacLow, settings_.address);
  set_word(kSupportedIpConfiguration, 0x5);
  set_word(kIpConfiguration, 0x5);
  set_word(kAddress, settings_.address);
  set_word(kSubnetMask, 0xff000000);
  set_text(kManufacturer, 32, "Strobe");
  set_text(kModel, 32, "SimulatedCamera");
  set_text(kDeviceVersion, 32, "1.0");
  set_text(kManufacturerInfo, 48, "simulated: no light falls on it");
  set_text(kSerial, 16, settings_.serial);
  set_text(
      kFirstUrl, 512,
      fmt::format("local:simulated_camera.xml;{:x};{:x}", kDescriptionAddress, settings_.description.size()));
  set_word(kInterfaces, 1);
  set_word(kStreamChannels, 1);
  set_word(kCapability, 0xc0000007);  // user's name, serial number, resends, writing memory, concatenation
  set_word(kHeartbeatTimeout, kUsualHeartbeat_ms);
  set_word(kTickFrequency + 4, 1'000'000'000);
  set_word(kPacketSize, kUsualPacketSize);
}

void Device::set_payload_size() {
  const int size = settings_.width * settings_.height * bytes_per_pixel(pixel_format());
  const std::uint32_t told = settings_.payload_size_told;
  set_word(camera::kPayloadSize, told != 0 ? told : static_cast<std::uint32_t>(size));
}

void Device::set_text(std::uint32_t address, std::uint32_t size, const std::string& text) {
  std::copy_n(text.begin(), std::min<std::size_t>(text.size(), size - 1), memory(address, size));
}

std::uint8_t* Device::memory(std::uint32_t address, std::uint32_t size) {
  if (address < bootstrap_.size() && size <= bootstrap_.size() - address) return bootstrap_.data() + address;
  if (address < camera::kFirst) return nullptr;
  const std::uint32_t at = address - camera::kFirst;
  return at < own_.size() && size <= own_.size() - at ? own_.data() + at : nullptr;
}

const std::uint8_t* Device::memory(std::uint32_t address, std::uint32_t size) const {
  const std::string& text = settings_.description;
  if (address < kDescriptionAddress) return const_cast<Device*>(this)->memory(address, size);
  const std::uint32_t at = address - kDescriptionAddress;
  return at < text.size() && size <= text.size() - at ? reinterpret_cast<const std::uint8_t*>(&text[at])
                                                      : nullptr;
}

std::uint32_t Device::word(std::uint32_t address) const {
  const std::uint8_t* const bytes = memory(address, 4);
  return bytes == nullptr ? 0 : word_at({bytes, 4}, 0);
}

void Device::set_word(std::uint32_t address, std::uint32_t value) {
  if (std::uint8_t* const bytes = memory(address, 4)) store({bytes, 4}, 0, 4, value);
}

double Device::number(std::uint32_t address) const {
  return static_cast<double>(std::bit_cast<float>(word(address)));
}

void Device::set_number(std::uint32_t address, double value) {
  set_word(address, std::bit_cast<std::uint32_t>(static_cast<float>(value)));
}

std::uint64_t Device::ticks(MonoTime instant) const {
  const auto since = static_cast<double>((instant - powered_).count());
  const std::int64_t gained = std::llround(since * settings_.clock_drift_ppm * 1e-6);
  return static_cast<std::uint64_t>(clock_start_ns_ + (instant - powered_).count() + gained);
}

std::optional<Endpoint> Device::stream_destination() const {
  const Endpoint to{word(kStreamAddress), static_cast<std::uint16_t>(word(kStreamPort))};
  // It plays on this machine only: nobody makes it flood another.
  constexpr std::uint32_t kLoopback = 127;
  return to.port == 0 || to.address >> 24 != kLoopback ? std::nullopt : std::optional(to);
}

void Device::release_control() {
  controller_.reset();
  exclusive_ = false;
  acquires_since_.reset();
  set_word(kControl, 0);
  set_word(kStreamPort, 0);
  resend_requests_.clear();
  software_triggers_ = 0;
  test_packet_ = false;
}

void Device::check_heartbeat(MonoTime now) {
  if (controller_ && now - heard_ > milliseconds(word(kHeartbeatTimeout))) release_control();
}

bool Device::may_read(const Endpoint& sender) const { return !exclusive_ || controller_ == sender; }

/// Receivers ask from the socket that the stream comes to.
bool Device::may_ask_again(const Endpoint& sender) const {
  return controller_ == sender || stream_destination() == sender;
}

Status Device::write_control(std::uint32_t value, const Endpoint& sender) {
  if (controller_ && controller_ != sender) return Status::access_denied;
  if ((value & ~kWritesOfControl) != 0) return Status::invalid_parameter;
  if (value == 0) {
    release_control();
    return Status::success;
  }
  controller_ = sender;
  exclusive_ = (value & kExclusive) != 0;
  set_word(kControl, value);
  return Status::success;
}

Status Device::write(std::uint32_t address, std::uint32_t value, const Endpoint& sender, MonoTime now) {
  if (address % 4 != 0) return Status::bad_alignment;
  if (std::as_const(*this).memory(address, 4) == nullptr) return Status::invalid_address;
  if (address == kControl) {
    const Status status = write_control(value, sender);
    heard_ = status == Status::success ? now : heard_;
    return status;
  }
  if (!may_write(sender)) return Status::access_denied;
  const bool of_stream = address == kStreamPort || address == kStreamAddress;
  if (of_stream) {
    stream_opened_ = stream_opened_ || (address == kStreamPort && value != 0);
    set_word(address, value);
    return Status::success;
  }
  const auto all = features();
  const auto feature = std::ranges::find_if(all, [&](const Feature& f) { return holds(f, address); });
  if (feature == all.end()) return Status::write_protect;
  if (address < kTextsEnd) {
    set_word(address, value);
    return Status::success;
  }
  return write_feature(*feature, value, now);
}

Status Device::write_feature(const Feature& feature, std::uint32_t value, MonoTime now) {
  std::uint32_t kept = value;
  if (feature.kind == FeatureKind::command) {
    act(feature.address, value, now);
    return Status::success;
  }
  if (feature.address == kPacketSize) {
    kept = value & kPacketSizeMask & ~3U;
    test_packet_ = test_packet_ || (value & kFireTestPacket) != 0;
  }
  if (feature.kind == FeatureKind::enumeration &&
      std::ranges::none_of(feature.choices, [&](const Choice& choice) { return choice.value == value; }))
    return Status::invalid_parameter;
  const double number = feature.kind == FeatureKind::number ? static_cast<double>(std::bit_cast<float>(kept))
                                                            : static_cast<double>(kept);
  if (!(number >= feature.min && number <= feature.max)) return Status::invalid_parameter;
  set_word(feature.address, kept);
  set_payload_size();
  if (feature.address == camera::kExposureTime) {
    const double step_us = settings_.exposure_step_us;
    set_number(feature.address, std::max(step_us, step_us * std::round(number / step_us)));
  }
  return Status::success;
}

void Device::act(std::uint32_t address, std::uint32_t value, MonoTime now) {
  if (value == 0) return;
  switch (address) {
    case kTimestampControl:
      if ((value & kReset) != 0) {
        powered_ = now;
        clock_start_ns_ = 0;
      }
      if ((value & kLatch) != 0) {
        set_word(kTimestamp, static_cast<std::uint32_t>(ticks(now) >> 32));
        set_word(kTimestamp + 4, static_cast<std::uint32_t>(ticks(now)));
      }
      return;
    case camera::kAcquisitionStart:
      if (!acquires_since_) acquires_since_ = now;
      return;
    case camera::kAcquisitionStop:
      acquires_since_.reset();
      return;
    case camera::kTriggerSoftware:
      ++software_triggers_;
      return;
    default:
      return;
  }
}

}  // namespace strobe::sim::gev
