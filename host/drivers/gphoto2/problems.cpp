#include "host/drivers/gphoto2/problems.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <initializer_list>
#include <string_view>

namespace strobe::gphoto2 {

namespace {

using tether::Problem;

constexpr std::uint64_t kOnePhotograph = 100'000'000;  // bytes, a large RAW
constexpr std::uint64_t kFewPhotographs = 50 * kOnePhotograph;
constexpr int kBatteryLow_percent = 20;
constexpr std::int64_t kClockOff_s = 120;
constexpr std::int64_t kZoneStep_s = 900;  // cameras keep local time or another, all quarters of an hour off
constexpr std::int64_t kLargestZone_s = 15 * 3600;
constexpr std::initializer_list<const char*> kModes{"autoexposuremodedial", "autoexposuremode", "expprogram"};
constexpr std::initializer_list<const char*> kTimes{"shutterspeed", "shutterspeed2"};

class Finder {
 public:
  explicit Finder(const CameraState& state) : state_(state) {}

  std::vector<Problem> find() {
    find_files();
    find_noise_reduction();
    find_automatics();
    find_mode();
    find_drive();
    find_store();
    find_battery();
    find_sleep();
    find_clock();
    return std::move(problems_);
  }

 private:
  /// Returns nullopt if the camera has none of these settings.
  std::optional<std::string> original(std::initializer_list<const char*> names) const {
    for (const char* name : names) {
      const auto found = state_.config.find(name);
      if (found != state_.config.end() && !found->second.value.empty()) return found->second.value;
    }
    return std::nullopt;
  }
  std::optional<std::string> value(std::initializer_list<const char*> names) const {
    const auto text = original(names);
    return text ? std::optional(lower_case(*text)) : std::nullopt;
  }
  static bool has(const std::optional<std::string>& text, std::initializer_list<std::string_view> words) {
    return text &&
           std::ranges::any_of(words, [&](std::string_view word) { return text->find(word) != text->npos; });
  }
  static bool is(const std::optional<std::string>& text, std::initializer_list<std::string_view> words) {
    return text && std::ranges::find(words, *text) != words.end();
  }
  void warn(std::string text) { problems_.push_back({false, std::move(text)}); }
  void prevent(std::string text) { problems_.push_back({true, std::move(text)}); }

  void find_files() {
    const auto files = written_files(state_.config);
    if (files && !files->raw)
      warn(
          "it writes no RAW files: a JPEG's numbers are not proportional to light; set its image quality or "
          "format to RAW");
    if (files && files->raw && files->jpeg)
      warn("it writes a JPEG beside each RAW file, which is not taken over: RAW alone comes sooner");
  }
  void find_noise_reduction() {
    if (has(value({"longexpnr", "longexposurenoisereduction"}), {"on", "auto", "1"}))
      warn(
          "long-exposure noise reduction is on: each photograph takes twice as long, and the camera is deaf "
          "meanwhile; switch it off in its menu");
  }
  void find_automatics() {
    if (has(value({"iso"}), {"auto"}) || is(value({"isoauto", "autoiso"}), {"on", "1"}))
      warn("ISO is automatic: photographs differ in brightness and noise; set a number");
    const auto focus = value({"focusmode", "focusmode2"});
    if (has(focus, {"af", "auto", "one shot", "ai ", "servo"}))
      warn(
          "autofocus is on: in the dark it hunts, and the shutter may not open; set the lens to MF and tape "
          "it");
  }
  void find_mode() {
    const auto mode = value(kModes);
    const bool bulb_mode = has(mode, {"bulb"}) || is(mode, {"b"});
    if (mode && !bulb_mode && !is(mode, {"m", "manual"}))
      prevent(fmt::format("its exposure mode is {}: turn the dial to M or B", *original(kModes)));
    const auto time = value(kTimes);
    if (state_.exposure_by_line && time && !bulb_mode && !has(time, {"bulb", "time"}))
      prevent(
          fmt::format("its shutter speed is {}: the line holds the shutter open in bulb only; set "
                      "shutterspeed = \"bulb\", or turn the dial",
                      *original(kTimes)));
    if (!state_.exposure_by_line && has(time, {"bulb"}))
      prevent("its shutter speed is bulb, but exposures are to be timed: set shutterspeed to a time");
  }
  void find_drive() {
    const auto drive = value({"drivemode", "capturemode"});
    if (has(drive, {"timer"})) prevent("the self-timer is on: set single pictures");
    if (has(drive, {"mirror", "mup"}))
      prevent(
          "mirror-up is a drive mode: the first pulse only raises the mirror; set single pictures, and "
          "anti-shock or exposure delay if it has them");
    if (has(drive, {"contin", "burst", "high speed"}))
      warn("pictures are taken in bursts: a shot may have several; set single pictures");
    if (is(value({"imagereview"}), {"on"}) || (has(value({"reviewtime"}), {"s", "hold"})))
      warn("picture review is on: it costs battery, and some cameras wait for it; switch it off");
  }
  void find_store() {
    const auto shots = value({"availableshots"});
    if ((state_.free_bytes && *state_.free_bytes < kOnePhotograph) || is(shots, {"0"})) {
      prevent("its card is full: empty it, or set delete_from_camera");
    } else if (state_.free_bytes && *state_.free_bytes < kFewPhotographs) {
      warn(fmt::format("{:.1f} GB are free on its card: some tens of photographs",
                       static_cast<double>(*state_.free_bytes) * 1e-9));
    }
  }
  void find_battery() {
    const auto battery = value({"batterylevel"});
    if (!battery) return;
    const bool is_number = std::isdigit(static_cast<unsigned char>(battery->front())) != 0;
    const int percent = is_number ? std::atoi(battery->c_str()) : 100;
    if (percent < kBatteryLow_percent || has(battery, {"low", "exhaust"}))
      warn(fmt::format("its battery is at {}: change it, or feed it from the mains",
                       *original({"batterylevel"})));
  }
  void find_sleep() {
    const auto sleep = value({"autopoweroff", "meterofftime"});
    if (sleep && !is(sleep, {"0", "off", "disable", "none", "no limit", "unlimited"}))
      warn(fmt::format("it goes to sleep after {} (s, if it says no more): switch that off in its menu",
                       *sleep));
  }
  void find_clock() {
    const auto time = value({"datetime", "datetimeutc"});
    if (!time) return;
    const std::int64_t off_s = std::atoll(time->c_str()) - state_.now_s;
    const std::int64_t within_zone_s = std::abs(off_s) % kZoneStep_s;
    if (std::abs(off_s) > kLargestZone_s ||
        std::min(within_zone_s, kZoneStep_s - within_zone_s) > kClockOff_s)
      warn("its clock is wrong: files bear wrong times; set it in its menu");
  }

  const CameraState& state_;
  std::vector<Problem> problems_;
};

}  // namespace

std::vector<Problem> find_problems(const CameraState& state) { return Finder(state).find(); }

std::optional<WrittenFiles> written_files(const Config& config) {
  constexpr std::array kNames{"imageformat", "imageformatsd", "imageformatcf", "imagequality"};
  constexpr std::array<std::string_view, 6> kRaw{"raw", "nef", "cr2", "cr3", "arw", "rw2"};
  // Beside a RAW: Canon's RAW + Large Fine JPEG, Nikon's NEF+Fine.
  constexpr std::array<std::string_view, 2> kJpeg{"jpeg", "+"};
  for (const char* name : kNames) {
    const auto found = config.find(name);
    if (found == config.end() || found->second.value.empty()) continue;
    const std::string text = lower_case(found->second.value);
    const auto any = [&text](const auto& words) {
      return std::ranges::any_of(words, [&](std::string_view word) { return text.find(word) != text.npos; });
    };
    const bool raw = any(kRaw);
    return WrittenFiles{raw, !raw || any(kJpeg)};
  }
  return std::nullopt;
}

}  // namespace strobe::gphoto2
