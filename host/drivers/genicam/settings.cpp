#include "host/drivers/genicam/settings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include "host/drivers/genicam/pixel_format.hpp"

namespace strobe::genicam {
namespace {

using tether::Setting;
using tether::SettingState;

struct Switch {
  const char* name;
  const char* off;
};

// Of many makers: what is not there is not asked for.
constexpr std::array kOptional{
    Switch{"BlackLevelAuto", "Off"},
    Switch{"BalanceWhiteAuto", "Off"},
    Switch{"BslLightSourcePreset", "Off"},
    Switch{"GammaEnable", "false"},
    Switch{"Gamma", "1"},
    Switch{"SharpeningEnable", "false"},
    Switch{"SharpnessEnable", "false"},
    Switch{"SharpnessEnhancement", "0"},
    Switch{"BslSharpnessEnhancement", "0"},
    Switch{"NoiseReduction", "0"},
    Switch{"BslNoiseReduction", "0"},
    Switch{"PgiMode", "Off"},
    Switch{"ConvolutionMode", "Off"},
    Switch{"ContrastEnable", "false"},
    Switch{"LUTEnable", "false"},
    Switch{"ColorTransformationEnable", "false"},
    Switch{"DigitalShift", "0"},
    Switch{"DigitalShiftEnable", "false"},
    Switch{"DefectCorrectStaticEnable", "false"},
    Switch{"DefectCorrectionEnable", "false"},
    Switch{"DefectMaskEnable", "false"},
    Switch{"DefectPixelCorrectionMode", "Off"},
    Switch{"BslDefectPixelCorrectionMode", "Off"},
    Switch{"BinningHorizontal", "1"},
    Switch{"BinningVertical", "1"},
    Switch{"DecimationHorizontal", "1"},
    Switch{"DecimationVertical", "1"},
    Switch{"TestPattern", "Off"},
    Switch{"TestImageSelector", "Off"},
    Switch{"AcquisitionFrameRateEnable", "false"},
    Switch{"ChunkModeActive", "false"},
};

constexpr std::array kRead{"Width",
                           "Height",
                           "OffsetX",
                           "OffsetY",
                           "BlackLevel",
                           "BlackLevelRaw",
                           "PixelColorFilter",
                           "SensorBitDepth",
                           "GevSCPD",
                           "DeviceTapGeometry",
                           "DeviceLinkThroughputLimitMode",
                           "DeviceLinkThroughputLimit",
                           "ExposureTime"};

bool contains(const std::vector<std::string>& list, const std::string& text) {
  return std::ranges::find(list, text) != list.end();
}

std::string joined(const std::vector<std::string>& list) { return fmt::format("{}", fmt::join(list, ", ")); }

}  // namespace

std::string Settings::present(const std::vector<std::string>& names) const {
  for (const std::string& name : names) {
    if (camera_->kind(name) != Kind::absent) return name;
  }
  return "";
}

/// spoils: what is wrong with photographs if the camera does not do it.
void Settings::set(const std::string& name, const std::string& value, bool prevents,
                   const std::string& spoils) {
  const auto own = request_.set.find(name);
  const std::string asked = own != request_.set.end() ? own->second : value;
  const Kind kind = camera_->kind(name);
  Setting setting{name, asked, "", SettingState::absent, ""};
  if (kind != Kind::absent) {
    const std::string before = camera_->get(name).value_or("");
    const auto done = is_same(kind, asked, before) ? Result<void>() : camera_->set(name, asked);
    const auto is = camera_->get(name);
    setting = judged(name, kind, asked, before, is.value_or(""), done ? "" : done.error().message);
  }
  const bool good = setting.state == SettingState::as_asked || setting.state == SettingState::rounded;
  if (!good && !spoils.empty())
    problems_.push_back(
        {prevents,
         fmt::format("{} is {} instead of {}{}: {}", name, setting.is.empty() ? "absent" : setting.is, asked,
                     setting.remark.empty() ? "" : " (" + setting.remark + ")", spoils)});
  std::erase_if(settings_, [&](const Setting& earlier) { return earlier.name == name; });
  settings_.push_back(std::move(setting));
}

void Settings::set_entry(const std::string& name, const std::vector<std::string>& entries, bool prevents,
                         const std::string& spoils) {
  const std::vector<std::string> has = camera_->entries(name);
  const auto found = std::ranges::find_if(entries, [&](const std::string& e) { return contains(has, e); });
  set(name, found != entries.end() ? *found : entries.front(), prevents, spoils);
}

/// Of the selector's other triggers none may hold frames back.
void Settings::set_trigger() {
  const std::vector<std::string> selectors = camera_->entries("TriggerSelector");
  constexpr const char* kSpoils = "it does not expose by the line";
  if (!selectors.empty()) {
    for (const std::string& selector : selectors) {
      if (!camera_->set("TriggerSelector", selector) || camera_->get("TriggerMode").value_or("Off") == "Off")
        continue;
      if (const auto off = camera_->set("TriggerMode", "Off"); !off)
        problems_.push_back(
            {false, fmt::format("the trigger {} stays on: {}", selector, off.error().message)});
    }
    set_entry("TriggerSelector", {"FrameStart", "ExposureActive", "ExposureStart", "AcquisitionStart"}, true,
              kSpoils);
  }
  set("TriggerMode", "On", true, "it photographs all the time");
  std::vector<std::string> lines;
  for (const std::string& source : camera_->entries("TriggerSource")) {
    if (source.starts_with("Line")) lines.push_back(source);
  }
  // Line 0 is an input with some makers, an output with others; line 1 an input with most.
  std::stable_partition(lines.begin(), lines.end(), [](const std::string& line) { return line == "Line1"; });
  if (lines.empty()) lines.push_back("Line1");
  set("TriggerSource", lines.front(), true, kSpoils);
  set_entry("TriggerActivation", {"RisingEdge", "LevelHigh"}, false, "it may expose at the wrong edge");
  if (const std::string delay = present({"TriggerDelay", "TriggerDelayAbs"}); !delay.empty())
    set(delay, "0", false, "it begins to expose too late");
  set_line(camera_->get("TriggerSource").value_or(lines.front()));
}

void Settings::set_line(const std::string& line) {
  if (!contains(camera_->entries("LineSelector"), line)) return;
  set("LineSelector", line, false, "");
  if (camera_->kind("LineMode") != Kind::absent)
    set("LineMode", "Input", true, "the line is no input, so that nothing triggers it");
  if (camera_->kind("LineInverter") != Kind::absent)
    set("LineInverter", "false", true, "it exposes while the line is not active");
}

void Settings::set_timed() {
  set("ExposureMode", "Timed", false, "");
  const std::string time = present({"ExposureTime", "ExposureTimeAbs"});
  if (time.empty()) {
    problems_.push_back({true, "it has no exposure time that can be set"});
    return;
  }
  set(time, fmt::to_string(request_.exposure_s * 1e6), true, "it exposes too short or too long");
}

void Settings::set_exposure() {
  if (const std::string automatic = present({"ExposureAuto"}); !automatic.empty())
    set(automatic, "Off", true, "it chooses the exposure itself");
  const std::vector<std::string> modes = camera_->entries("ExposureMode");
  const bool can = contains(modes, "TriggerWidth") || contains(modes, "TriggerControlled");
  const auto own = request_.set.find("ExposureMode");
  const bool own_timed = own != request_.set.end() && own->second == "Timed";
  if (request_.exposure_by_line && can && !own_timed) {
    set_entry("ExposureMode", {"TriggerWidth", "TriggerControlled"}, true,
              "it does not expose as long as the line");
  } else {
    set_timed();
    if (request_.exposure_by_line && !own_timed)
      problems_.push_back(
          {false,
           fmt::format("it cannot expose while the line is active (ExposureMode TriggerWidth): it exposes "
                       "for {} s from the line's edge on, so let that cover the whole train",
                       request_.exposure_s)});
  }
  const std::string mode = camera_->get("ExposureMode").value_or("Timed");
  exposure_ = mode == "Timed" ? fmt::format("{} s from the edge of {} on (Timed)", request_.exposure_s,
                                            camera_->get("TriggerSource").value_or("the trigger"))
                              : fmt::format("while {} is active ({})",
                                            camera_->get("TriggerSource").value_or("the trigger"), mode);
}

/// A colour sensor's grey is interpolated: its edges lie elsewhere.
void Settings::set_pixel_format() {
  const std::vector<std::string> has = camera_->entries("PixelFormat");
  const bool colour = camera_->get("PixelColorFilter").value_or("None") != "None";
  std::vector<std::string> wanted;
  for (const PixelFormat& format : pixel_formats()) {
    if (contains(has, std::string(format.name))) wanted.emplace_back(format.name);
  }
  if (colour) {
    std::ranges::stable_partition(wanted, [](const std::string& name) { return name.starts_with("Bayer"); });
  }
  if (wanted.empty()) wanted.push_back("Mono12");
  set("PixelFormat", wanted.front(), true, "its pixels are not understood: it has " + joined(has));
  const std::string is = camera_->get("PixelFormat").value_or("");
  const PixelFormat* format = find_pixel_format(std::string_view(is));
  if (format == nullptr) {
    problems_.push_back({true, fmt::format("PixelFormat is {}, which is not understood: use one of {}", is,
                                           wanted.empty() ? "Mono8 to Mono16" : joined(wanted))});
  } else if (format->bits == 8) {
    problems_.push_back({false, fmt::format("PixelFormat is {}: 256 steps are few for a dark background and "
                                            "bright images together",
                                            is)});
  }
}

void Settings::set_lowest_gain() {
  if (camera_->kind("GainAuto") != Kind::absent)
    set("GainAuto", "Off", false, "brightness differs between shots");
  const std::string gain = present({"Gain", "GainAbs", "GainRaw"});
  if (gain.empty()) return;
  const auto range = camera_->range(gain);
  set(gain, fmt::to_string(range ? std::clamp(0.0, range->min, range->max) : 0.0), false,
      "more noise, and less light until it is full");
}

void Settings::switch_off_corrections() {
  for (const Switch& one : kOptional) {
    if (camera_->kind(one.name) != Kind::absent)
      set(one.name, one.off, false, "the sensor's own numbers are changed");
  }
}

/// What the request sets that the driver would not. Selectors come first: they say what the others are of.
void Settings::set_asked_besides() {
  std::vector<std::pair<std::string, std::string>> besides;
  for (const auto& entry : request_.set) {
    if (std::ranges::find(settings_, entry.first, &Setting::name) == settings_.end())
      besides.push_back(entry);
  }
  std::ranges::stable_partition(besides, [](const auto& entry) { return entry.first.ends_with("Selector"); });
  for (const auto& [name, value] : besides) set(name, value, true, "the rig file asks for it");
}

void Settings::read_others() {
  for (const char* name : kRead) {
    if (std::ranges::find(settings_, name, &Setting::name) != settings_.end()) continue;
    // While the line says how long, its value is of no exposure.
    if (std::string_view(name) == "ExposureTime" && camera_->get("ExposureMode").value_or("Timed") != "Timed")
      continue;
    if (const auto is = camera_->get(name)) settings_.push_back({name, "", *is, SettingState::read, ""});
  }
}

/// A frame comes faster than this program may be given the processor.
void Settings::judge_network() {
  if (!camera_->is_gige()) return;
  constexpr std::uint32_t kCapabilities = 0x0934, kResends = 1U << 2;  // GigE Vision 2.0, 28.2
  if (const auto can = camera_->read_register(kCapabilities); can && (*can & kResends) == 0)
    problems_.push_back(
        {false, "it does not send missing packets again: a lost packet is a lost photograph"});
  std::int64_t most_bytes = 0;
  std::ifstream("/proc/sys/net/core/rmem_max") >> most_bytes;
  const auto payload = std::strtod(camera_->get("PayloadSize").value_or("0").c_str(), nullptr);
  if (most_bytes > 0 && static_cast<double>(most_bytes) < payload)
    problems_.push_back(
        {false,
         fmt::format("the kernel keeps {} kB of a frame of {:.0f} kB while this computer is busy: packets "
                     "may be lost and asked for again (sysctl -w net.core.rmem_max={:.0f})",
                     most_bytes / 1000, payload / 1000.0, 2.0 * payload)});
}

Settings::Settings(Camera& camera, const tether::OpenRequest& request) : camera_(&camera), request_(request) {
  set("AcquisitionMode", "Continuous", true, "it stops after a photograph");
  set_trigger();
  set_pixel_format();
  set_exposure();
  set_lowest_gain();
  switch_off_corrections();
  set_asked_besides();
  read_others();
  judge_network();
  camera_ = nullptr;
}

bool Settings::look_again(const Camera& camera) {
  if (settings_.empty()) return false;
  Setting& setting = settings_[next_++ % settings_.size()];
  if (setting.state == SettingState::absent) return false;
  const auto is = camera.get(setting.name);
  if (!is || is_same(camera.kind(setting.name), setting.is, *is)) return false;
  const std::string what =
      fmt::format("{} has changed by itself from {} to {}", setting.name, setting.is, *is);
  const bool prevents = setting.name.starts_with("Trigger") || setting.name.starts_with("Exposure") ||
                        setting.name.starts_with("Pixel") || setting.name == "Width" ||
                        setting.name == "Height";
  std::erase_if(problems_, [&](const auto& p) { return p.text.starts_with(setting.name + " has changed"); });
  problems_.push_back({prevents, what});
  setting.is = *is;
  setting.remark = what;
  if (setting.state != SettingState::read) setting.state = SettingState::refused;
  return true;
}

}  // namespace strobe::genicam
