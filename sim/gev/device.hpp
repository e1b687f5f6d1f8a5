// The simulated camera as GVCP (GigE Vision 1.2, sections 7 to 20 and 28) sees it: its memory, who controls
// it, its clock. Time and datagrams come from outside: no clock, no sockets. One thread; allocates.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/units/time.hpp"
#include "sim/gev/bytes.hpp"
#include "sim/gev/description.hpp"

namespace strobe::sim::gev {

/// Status codes of acknowledges.
enum class Status : std::uint16_t {
  success = 0x0000,
  not_implemented = 0x8001,
  invalid_parameter = 0x8002,
  invalid_address = 0x8003,
  write_protect = 0x8004,
  bad_alignment = 0x8005,
  access_denied = 0x8006,
  packet_unavailable = 0x800c,
  invalid_header = 0x800e,
};

/// IPv4, as numbers.
struct Endpoint {
  std::uint32_t address = 0;
  std::uint16_t port = 0;
  bool operator==(const Endpoint&) const = default;
};

/// What a device is from its power-up on.
struct DeviceSettings {
  std::uint32_t address = 0x7f000001;
  std::string serial;
  int width = 0, height = 0;  ///< px
  PixelFormat pixel_format = PixelFormat::mono8;
  double exposure_step_us = 10.0;       ///< exposure times are rounded to it, > 0
  double clock_offset_s = 0.0;          ///< what its clock shows at power-up
  double clock_drift_ppm = 0.0;         ///< how much faster than the rig's it runs
  std::string description;              ///< XML
  std::uint32_t payload_size_told = 0;  ///< in place of the true one; 0: that
};

struct PacketRange {
  std::uint16_t block = 0;
  std::uint32_t first = 0, last = 0;
};

class Device {
 public:
  Device(const DeviceSettings& settings, MonoTime now);

  /// The answer to a datagram of the control channel; nullopt: none is due. What is no command, or is cut
  /// short in its header, gets none.
  std::optional<Packet> answer(Bytes datagram, const Endpoint& sender, MonoTime now);
  /// An application that controls it and has said nothing for the heartbeat's timeout loses control.
  void check_heartbeat(MonoTime now);
  /// As after it was switched on.
  void power_up(MonoTime now);

  /// Its own clock. [ns]
  std::uint64_t ticks(MonoTime instant) const;

  bool acquires() const { return acquires_since_.has_value(); }
  std::optional<MonoTime> acquires_since() const { return acquires_since_; }
  void stop_acquisition() { acquires_since_.reset(); }

  std::uint32_t word(std::uint32_t address) const;
  double number(std::uint32_t address) const;  ///< of a float register
  void set_word(std::uint32_t address, std::uint32_t value);
  void set_number(std::uint32_t address, double value);
  PixelFormat pixel_format() const { return static_cast<PixelFormat>(word(camera::kPixelFormat)); }
  /// Where frames go; nullopt: nowhere.
  std::optional<Endpoint> stream_destination() const;

  // What the last commands asked for besides; taken once.
  /// The stream's channel was opened: its blocks are counted from 1 on.
  bool take_stream_opened() { return std::exchange(stream_opened_, false); }
  bool take_test_packet() { return std::exchange(test_packet_, false); }
  int take_software_triggers() { return std::exchange(software_triggers_, 0); }
  std::vector<PacketRange> take_resend_requests() { return std::exchange(resend_requests_, {}); }

 private:
  struct Command;
  Status execute(const Command& command, const Endpoint& sender, MonoTime now, Packet& reply);
  Status read_registers(const Command& command, Packet& reply) const;
  Status write_registers(const Command& command, const Endpoint& sender, MonoTime now, Packet& reply);
  Status read_memory(const Command& command, Packet& reply) const;
  Status write_memory(const Command& command, const Endpoint& sender, MonoTime now, Packet& reply);
  Status take_resend(const Command& command);
  bool may_write(const Endpoint& sender) const { return controller_ == sender; }
  bool may_read(const Endpoint& sender) const;
  bool may_ask_again(const Endpoint& sender) const;
  Status write(std::uint32_t address, std::uint32_t value, const Endpoint& sender, MonoTime now);
  Status write_control(std::uint32_t value, const Endpoint& sender);
  Status write_feature(const Feature& feature, std::uint32_t value, MonoTime now);
  void act(std::uint32_t address, std::uint32_t value, MonoTime now);
  void release_control();
  void set_text(std::uint32_t address, std::uint32_t size, const std::string& text);
  void set_bootstrap();
  void set_payload_size();
  /// Null: no memory is there.
  const std::uint8_t* memory(std::uint32_t address, std::uint32_t size) const;
  std::uint8_t* memory(std::uint32_t address, std::uint32_t size);

  DeviceSettings settings_;
  std::array<std::uint8_t, 0x1000> bootstrap_{};
  std::array<std::uint8_t, camera::kEnd - camera::kFirst> own_{};
  MonoTime powered_;
  std::int64_t clock_start_ns_ = 0;  ///< what the clock showed then
  std::optional<Endpoint> controller_;
  bool exclusive_ = false;
  MonoTime heard_;
  std::optional<MonoTime> acquires_since_;
  bool stream_opened_ = false;
  bool test_packet_ = false;
  int software_triggers_ = 0;
  std::vector<PacketRange> resend_requests_;
};

}  // namespace strobe::sim::gev
