#include "sim/gev/description.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

namespace strobe::sim::gev {
namespace {

constexpr std::array kOffOn{Choice{"Off", 0}, Choice{"On", 1}};
constexpr std::array kOffContinuous{Choice{"Off", 0}, Choice{"Continuous", 1}};
constexpr std::array kPixelFormats{Choice{"Mono8", static_cast<std::uint32_t>(PixelFormat::mono8)},
                                   Choice{"Mono12", static_cast<std::uint32_t>(PixelFormat::mono12)},
                                   Choice{"Mono16", static_cast<std::uint32_t>(PixelFormat::mono16)},
                                   Choice{"BayerRG12", static_cast<std::uint32_t>(PixelFormat::bayer_rg12)}};
constexpr std::array kAcquisitionModes{Choice{"Continuous", 0}, Choice{"SingleFrame", 1}};
constexpr std::array kSelectors{Choice{"FrameStart", 0}};
constexpr std::array kSources{Choice{"Line1", 0}, Choice{"Software", 1}};
constexpr std::array kActivations{Choice{"RisingEdge", 0}, Choice{"LevelHigh", 1}};
constexpr std::array kExposureModes{Choice{"Timed", 0}, Choice{"TriggerWidth", 1}};

constexpr const char *kDevice = "DeviceControl", *kImage = "ImageFormatControl",
                     *kAcquisition = "AcquisitionControl", *kAnalog = "AnalogControl",
                     *kTransport = "TransportLayerControl";
constexpr bool kReadOnly = false;
constexpr double kMaxWord = 4294967295.0;

Feature integer(const char* category, const char* name, std::uint32_t address, bool writable, double min,
                double max, const char* unit = "") {
  return {category, name, FeatureKind::integer, address, 4, writable, min, max, unit};
}
Feature long_integer(const char* category, const char* name, std::uint32_t address) {
  return {category, name, FeatureKind::integer, address, 8, kReadOnly};
}
Feature number(const char* category, const char* name, std::uint32_t address, bool writable, double min,
               double max, const char* unit) {
  return {category, name, FeatureKind::number, address, 4, writable, min, max, unit};
}
Feature text(const char* name, std::uint32_t address, std::uint32_t size, bool writable = kReadOnly) {
  return {kDevice, name, FeatureKind::text, address, size, writable};
}
Feature choice(const char* category, const char* name, std::uint32_t address,
               std::span<const Choice> choices) {
  return {category, name, FeatureKind::enumeration, address, 4, true, 0.0, kMaxWord, "", choices};
}
Feature command(const char* category, const char* name, std::uint32_t address, std::uint32_t value = 1) {
  return {category, name, FeatureKind::command, address, 4, true, 0.0, kMaxWord, "", {}, value};
}

std::vector<Feature> all_features() {
  using namespace bootstrap;
  using namespace camera;
  return {
      text("DeviceVendorName", kManufacturer, 32),
      text("DeviceModelName", kModel, 32),
      text("DeviceVersion", kDeviceVersion, 32),
      text("DeviceSerialNumber", kSerial, 16),
      text("DeviceUserID", kUserName, 16, true),
      number(kDevice, "DeviceTemperature", kTemperature, kReadOnly, -40.0, 120.0, "C"),
      command(kDevice, "TimestampReset", kTimestampControl, 1),
      command(kDevice, "TimestampLatch", kTimestampControl, 2),
      long_integer(kDevice, "TimestampLatchValue", kTimestamp),
      integer(kImage, "SensorWidth", kSensorWidth, kReadOnly, 0, kMaxWord),
      integer(kImage, "SensorHeight", kSensorHeight, kReadOnly, 0, kMaxWord),
      integer(kImage, "Width", kWidth, kReadOnly, 0, kMaxWord),
      integer(kImage, "Height", kHeight, kReadOnly, 0, kMaxWord),
      integer(kImage, "OffsetX", kOffsetX, kReadOnly, 0, kMaxWord),
      integer(kImage, "OffsetY", kOffsetY, kReadOnly, 0, kMaxWord),
      choice(kImage, "PixelFormat", kPixelFormat, kPixelFormats),
      choice(kAcquisition, "AcquisitionMode", kAcquisitionMode, kAcquisitionModes),
      command(kAcquisition, "AcquisitionStart", kAcquisitionStart),
      command(kAcquisition, "AcquisitionStop", kAcquisitionStop),
      number(kAcquisition, "AcquisitionFrameRate", kFrameRate, true, 0.1, 100.0, "Hz"),
      choice(kAcquisition, "TriggerSelector", kTriggerSelector, kSelectors),
      choice(kAcquisition, "TriggerMode", kTriggerMode, kOffOn),
      choice(kAcquisition, "TriggerSource", kTriggerSource, kSources),
      choice(kAcquisition, "TriggerActivation", kTriggerActivation, kActivations),
      command(kAcquisition, "TriggerSoftware", kTriggerSoftware),
      choice(kAcquisition, "ExposureMode", kExposureMode, kExposureModes),
      number(kAcquisition, "ExposureTime", kExposureTime, true, 1.0, kMaxExposure_us, "us"),
      choice(kAcquisition, "ExposureAuto", kExposureAuto, kOffContinuous),
      number(kAnalog, "Gain", kGain, true, 0.0, 24.0, "dB"),
      choice(kAnalog, "GainAuto", kGainAuto, kOffContinuous),
      number(kAnalog, "BlackLevel", kBlackLevel, true, 0.0, 255.0, "DN"),
      choice(kAnalog, "BalanceWhiteAuto", kWhiteBalanceAuto, kOffContinuous),
      {kAnalog, "GammaEnable", FeatureKind::boolean, kGammaEnable, 4, true, 0.0, 1.0},
      number(kAnalog, "Gamma", kGamma, true, 0.3, 3.0, ""),
      integer(kTransport, "PayloadSize", kPayloadSize, kReadOnly, 0, kMaxWord, "B"),
      integer(kTransport, "GevSCPSPacketSize", kPacketSize, true, 576, 9000, "B"),
      integer(kTransport, "GevSCPD", kPacketDelay, true, 0, 1e6, "ticks"),
      integer(kTransport, "GevHeartbeatTimeout", kHeartbeatTimeout, true, 500, 60000, "ms"),
      long_integer(kTransport, "GevTimestampTickFrequency", kTickFrequency),
      command(kTransport, "GevTimestampControlLatch", kTimestampControl, 2),
      long_integer(kTransport, "GevTimestampValue", kTimestamp),
  };
}

const char* access(const Feature& feature) {
  return feature.kind == FeatureKind::command ? "WO" : feature.writable ? "RW" : "RO";
}

std::string register_node(const Feature& feature) {
  const bool floating = feature.kind == FeatureKind::number;
  const char* const node = floating ? "FloatReg" : "IntReg";
  return fmt::format(
      "<{} Name=\"{}Register\"><Address>0x{:x}</Address><Length>{}</Length><AccessMode>{}</AccessMode>"
      "<pPort>Device</pPort><Cachable>NoCache</Cachable>{}<Endianess>BigEndian</Endianess></{}>\n",
      node, feature.name, feature.address, feature.size, access(feature),
      floating ? "" : "<Sign>Unsigned</Sign>", node);
}

std::string unit(const Feature& feature) {
  return *feature.unit == '\0' ? "" : fmt::format("<Unit>{}</Unit>", feature.unit);
}

std::string value_node(const Feature& feature) {
  const std::string value = fmt::format("<pValue>{}Register</pValue>", feature.name);
  switch (feature.kind) {
    case FeatureKind::integer:
      return feature.size == 8
                 ? fmt::format("<Integer Name=\"{}\">{}</Integer>\n", feature.name, value)
                 : fmt::format("<Integer Name=\"{}\">{}<Min>{:.0f}</Min><Max>{:.0f}</Max>{}</Integer>\n",
                               feature.name, value, feature.min, feature.max, unit(feature));
    case FeatureKind::number:
      return fmt::format("<Float Name=\"{}\">{}<Min>{}</Min><Max>{}</Max>{}</Float>\n", feature.name, value,
                         feature.min, feature.max, unit(feature));
    case FeatureKind::boolean:
      return fmt::format("<Boolean Name=\"{}\">{}<OnValue>1</OnValue><OffValue>0</OffValue></Boolean>\n",
                         feature.name, value);
    case FeatureKind::command:
      return fmt::format("<Command Name=\"{}\">{}<CommandValue>{}</CommandValue></Command>\n", feature.name,
                         value, feature.command);
    case FeatureKind::enumeration: {
      std::string entries;
      for (const Choice& entry : feature.choices)
        entries +=
            fmt::format("<EnumEntry Name=\"{}\"><Value>{}</Value></EnumEntry>", entry.name, entry.value);
      return fmt::format("<Enumeration Name=\"{}\">{}{}</Enumeration>\n", feature.name, entries, value);
    }
    case FeatureKind::text:
      break;
  }
  return fmt::format(
      "<StringReg Name=\"{}\"><Address>0x{:x}</Address><Length>{}</Length><AccessMode>{}</AccessMode>"
      "<pPort>Device</pPort></StringReg>\n",
      feature.name, feature.address, feature.size, access(feature));
}

std::string categories() {
  std::string root, rest;
  for (const std::string_view category : {kDevice, kImage, kAcquisition, kAnalog, kTransport}) {
    root += fmt::format("<pFeature>{}</pFeature>", category);
    rest += fmt::format("<Category Name=\"{}\">", category);
    for (const Feature& feature : features())
      if (feature.category == category) rest += fmt::format("<pFeature>{}</pFeature>", feature.name);
    rest += "</Category>\n";
  }
  return "<Category Name=\"Root\">" + root + "</Category>\n" + rest;
}

constexpr const char* kHead =
    "<RegisterDescription ModelName=\"SimulatedCamera\" VendorName=\"Strobe\" ToolTip=\"\" "
    "StandardNameSpace=\"GEV\" SchemaMajorVersion=\"1\" SchemaMinorVersion=\"1\" SchemaSubMinorVersion=\"0\" "
    "MajorVersion=\"1\" MinorVersion=\"0\" SubMinorVersion=\"0\" "
    "ProductGuid=\"5f2c6a3e-7d0b-4c1b-9a55-0f6d7a2b9e11\" "
    "VersionGuid=\"b3c1d2e4-5a6f-4e7d-8c9b-1a2b3c4d5e6f\" "
    "xmlns=\"http://www.genicam.org/GenApi/Version_1_1\">\n";

}  // namespace

std::span<const Feature> features() {
  static const std::vector<Feature> all = all_features();
  return all;
}

const Feature* feature_at(std::uint32_t address) {
  const auto found = std::ranges::find(features(), address, &Feature::address);
  return found == features().end() ? nullptr : &*found;
}

std::string description() {
  std::string text = std::string("<?xml version=\"1.0\" encoding=\"utf-8\"?>\n") + kHead + categories();
  for (const Feature& feature : features()) {
    text += value_node(feature);
    if (feature.kind != FeatureKind::text) text += register_node(feature);
  }
  return text + "<Port Name=\"Device\"/>\n</RegisterDescription>\n";
}

std::string description_that_explodes() {
  std::string text = "<?xml version=\"1.0\"?>\n<!DOCTYPE RegisterDescription [\n<!ENTITY e0 \"strobe\">\n";
  constexpr int kDepth = 12;
  for (int i = 1; i <= kDepth; ++i) {
    text += fmt::format("<!ENTITY e{} \"", i);
    for (int k = 0; k < 10; ++k) text += fmt::format("&e{};", i - 1);
    text += "\">\n";
  }
  return text + fmt::format("]>\n{}<Category Name=\"&e{};\"/>\n</RegisterDescription>\n", kHead, kDepth);
}

}  // namespace strobe::sim::gev
