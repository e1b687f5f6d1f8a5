// What the simulated camera can be told and asked: one table of features by their names of the SFNC (Standard
// Features Naming Convention 2.4), each a register of the camera's memory, and the GenICam description
// (GenApi schema 1.1) that is made of it. Pure; thread-safe; allocates.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace strobe::sim::gev {

/// Bootstrap registers of GigE Vision 1.2 (section 28).
namespace bootstrap {
inline constexpr std::uint32_t kVersion = 0x0000, kDeviceMode = 0x0004, kMacHigh = 0x0008, kMacLow = 0x000c,
                               kSupportedIpConfiguration = 0x0010, kIpConfiguration = 0x0014,
                               kAddress = 0x0024, kSubnetMask = 0x0034, kManufacturer = 0x0048,
                               kModel = 0x0068, kDeviceVersion = 0x0088, kManufacturerInfo = 0x00a8,
                               kSerial = 0x00d8, kUserName = 0x00e8, kFirstUrl = 0x0200, kInterfaces = 0x0600,
                               kStreamChannels = 0x0904, kCapability = 0x0934, kHeartbeatTimeout = 0x0938,
                               kTickFrequency = 0x093c, kTimestampControl = 0x0944, kTimestamp = 0x0948,
                               kControl = 0x0a00, kStreamPort = 0x0d00, kPacketSize = 0x0d04,
                               kPacketDelay = 0x0d08, kStreamAddress = 0x0d18, kStreamSourcePort = 0x0d1c;
}  // namespace bootstrap

/// The camera's own.
namespace camera {
inline constexpr std::uint32_t kFirst = 0x10000;
inline constexpr std::uint32_t kSensorWidth = 0x10000, kSensorHeight = 0x10004, kWidth = 0x10008,
                               kHeight = 0x1000c, kOffsetX = 0x10010, kOffsetY = 0x10014,
                               kPixelFormat = 0x10018, kPayloadSize = 0x1001c, kAcquisitionMode = 0x10020,
                               kAcquisitionStart = 0x10024, kAcquisitionStop = 0x10028, kFrameRate = 0x1002c,
                               kTriggerSelector = 0x10030, kTriggerMode = 0x10034, kTriggerSource = 0x10038,
                               kTriggerActivation = 0x1003c, kTriggerSoftware = 0x10040,
                               kExposureMode = 0x10044, kExposureTime = 0x10048, kExposureAuto = 0x1004c,
                               kGain = 0x10050, kGainAuto = 0x10054, kBlackLevel = 0x10058,
                               kWhiteBalanceAuto = 0x1005c, kGammaEnable = 0x10060, kGamma = 0x10064,
                               kTemperature = 0x10068;
inline constexpr std::uint32_t kEnd = 0x1006c;
}  // namespace camera
inline constexpr std::uint32_t kDescriptionAddress = 0x100000;

/// Pixel Format Naming Convention 2.1.
enum class PixelFormat : std::uint32_t {
  mono8 = 0x01080001,
  mono12 = 0x01100005,
  mono16 = 0x01100007,
  bayer_rg12 = 0x01100011,
};
inline constexpr double kMaxExposure_us = 10e6;

enum class FeatureKind { integer, number, enumeration, boolean, command, text };

struct Choice {
  const char* name;
  std::uint32_t value;
};

struct Feature {
  const char* category;
  const char* name;
  FeatureKind kind;
  std::uint32_t address;
  std::uint32_t size = 4;  ///< bytes
  bool writable = true;
  double min = 0.0, max = 4294967295.0;  ///< integer and number
  const char* unit = "";
  std::span<const Choice> choices{};  ///< enumeration
  std::uint32_t command = 1;          ///< what is written
};

std::span<const Feature> features();
/// Null: none begins there.
const Feature* feature_at(std::uint32_t address);

/// The XML text.
std::string description();
/// One that would grow to billions of bytes where a reader replaces its entities.
std::string description_that_explodes();

}  // namespace strobe::sim::gev
