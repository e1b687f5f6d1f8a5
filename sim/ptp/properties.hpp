// What is set on the simulated camera: device properties of PTP (ISO 15740:2013, clause 13) and of Nikon's
// extension, described, read and written as a host does it. One thread at a time.
#pragma once

#include <algorithm>
#include <span>
#include <string>

#include "sim/ptp/dataset.hpp"
#include "sim/ptp/packets.hpp"

namespace strobe::sim::ptp {

/// What the camera writes for a photograph.
struct FilesWritten {
  bool raw = true;
  bool jpeg = false;
};

class Properties {
 public:
  /// As a photographer left it who knows what he does: manual, bulb, RAW.
  Properties();

  std::vector<std::uint16_t> codes() const;
  /// Data: the description, or the value; or why not.
  Answer description(std::uint16_t code) const;
  Answer value(std::uint16_t code) const;
  /// ISO is rounded to one that the camera has, as many cameras do; any other value that it has not is
  /// refused.
  Response set(std::uint16_t code, std::span<const std::uint8_t> data);

  std::uint64_t get(PropertyCode code) const;
  /// From the camera's side.
  void put(PropertyCode code, std::uint64_t value);
  void set_clock(std::string text);  ///< YYYYMMDDThhmmss

  FilesWritten files_written() const;

 private:
  enum class Type : std::uint16_t { u8 = 0x0002, u16 = 0x0004, u32 = 0x0006, text = 0xFFFF };
  enum class Form : std::uint8_t { none, range, enumeration };
  struct Property {
    PropertyCode code;
    Type type;
    Form form;
    bool writable;
    std::uint64_t value;
    std::vector<std::uint64_t> choices{};  ///< of a range: least, greatest, step
    std::string text{};
  };
  static bool holds(const Property& property, std::uint64_t value);
  static void write_value(DatasetWriter& writer, const Property& property, std::uint64_t value);
  static auto find(auto& properties, std::uint16_t code) {
    return std::ranges::find(properties, code, [](const Property& p) { return number(p.code); });
  }

  std::vector<Property> properties_;
};

}  // namespace strobe::sim::ptp
