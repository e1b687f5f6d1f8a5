#include "host/drivers/gphoto2/settings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <utility>

namespace strobe::gphoto2 {

namespace {

using tether::Setting;
using tether::SettingState;

constexpr std::array<std::pair<const char*, const char*>, 8> kOwn{{
    {"capturetarget", "Memory card"},
    {"longexpnr", "Off"},
    {"isoauto", "Off"},
    {"autoiso", "Off"},
    {"imagereview", "Off"},
    {"reviewtime", "None"},
    {"autopoweroff", "0"},
    {"autofocus", "Off"},
}};

/// As libgphoto2 2.5 names them for the makers' cameras.
constexpr std::array kRecorded{"lensname",
                               "iso",
                               "aperture",
                               "f-number",
                               "shutterspeed",
                               "shutterspeed2",
                               "imagequality",
                               "imageformat",
                               "imageformatsd",
                               "imageformatcf",
                               "imagesize",
                               "batterylevel",
                               "longexpnr",
                               "isoauto",
                               "autoiso",
                               "focusmode",
                               "focusmode2",
                               "autoexposuremode",
                               "autoexposuremodedial",
                               "expprogram",
                               "drivemode",
                               "capturemode",
                               "capturetarget",
                               "autopoweroff",
                               "meterofftime",
                               "imagereview",
                               "reviewtime",
                               "whitebalance",
                               "colorspace"};

constexpr std::size_t kChoicesTold = 12;

/// Of "f/5.6", "5.6", "0.5000s", "1/2".
std::optional<double> number_in(const std::string& text) {
  std::string rest = lower_case(text);
  if (rest.starts_with("f/")) rest.erase(0, 2);
  if (rest.ends_with("s")) rest.pop_back();
  const char* begin = rest.c_str();
  char* end = nullptr;
  const double number = std::strtod(begin, &end);
  if (end == begin) return std::nullopt;
  if (*end != '/') return *end == '\0' ? std::optional(number) : std::nullopt;
  const char* below = end + 1;
  const double divisor = std::strtod(below, &end);
  return end == below || *end != '\0' || divisor == 0.0 ? std::nullopt : std::optional(number / divisor);
}

bool same(const std::string& a, const std::string& b) {
  if (lower_case(a) == lower_case(b)) return true;
  constexpr double kPrintedDigits = 1e-4;
  const auto x = number_in(a), y = number_in(b);
  return x && y && std::abs(*x - *y) <= kPrintedDigits * std::abs(*x);
}

std::string listed(const std::vector<std::string>& choices) {
  std::string text;
  for (std::size_t i = 0; i < std::min(choices.size(), kChoicesTold); ++i)
    text += (i == 0 ? "" : ", ") + choices[i];
  return choices.size() > kChoicesTold ? text + ", …" : text;
}

Setting judged(const std::string& name, const std::string& asked, const Config& after,
               const std::map<std::string, std::string>& refused) {
  const auto found = after.find(name);
  if (found == after.end()) return {name, asked, "", SettingState::absent, ""};
  const ConfigValue& now = found->second;
  if (same(asked, now.value)) return {name, asked, now.value, SettingState::as_asked, ""};
  const auto why = refused.find(name);
  if (why == refused.end()) return {name, asked, now.value, SettingState::rounded, ""};
  std::string remark = now.read_only ? "it can be set on the camera only" : why->second;
  if (!now.choices.empty() && !now.read_only) remark += "; it has " + listed(now.choices);
  return {name, asked, now.value, SettingState::refused, remark};
}

}  // namespace

std::map<std::string, std::string> wanted_settings(const std::map<std::string, std::string>& asked,
                                                   const Config& config) {
  std::map<std::string, std::string> wanted = asked;
  for (const auto& [name, value] : kOwn) {
    const auto found = config.find(name);
    if (found != config.end() && !found->second.read_only) wanted.emplace(name, value);
  }
  return wanted;
}

std::string choice_for(const std::string& asked, const std::vector<std::string>& choices) {
  const auto found = std::ranges::find_if(choices, [&](const std::string& c) { return same(asked, c); });
  return found == choices.end() ? asked : *found;
}

std::map<std::string, std::string> apply(GphotoCamera& camera, const Config& before,
                                         const std::map<std::string, std::string>& wanted) {
  std::map<std::string, std::string> refused;
  for (const auto& [name, value] : wanted) {
    const auto found = before.find(name);
    if (found == before.end() || same(value, found->second.value)) continue;
    const auto set = camera.set(name, choice_for(value, found->second.choices));
    if (!set) refused[name] = set.error().message;
  }
  return refused;
}

TimeChoice nearest_time(const Config& config, double exposure_s) {
  TimeChoice best;
  double least = HUGE_VAL;
  for (const char* name : {"shutterspeed", "shutterspeed2"}) {
    const auto found = config.find(name);
    if (found == config.end() || found->second.read_only || !best.name.empty()) continue;
    for (const std::string& choice : found->second.choices) {
      const double time_s = number_in(choice).value_or(0.0);
      const double off = time_s > 0.0 ? std::abs(std::log(time_s / exposure_s)) : HUGE_VAL;
      if (off < least) best = {name, choice};
      least = std::min(least, off);
    }
  }
  return best;
}

std::vector<Setting> settings_of(const Config& after, const std::map<std::string, std::string>& wanted,
                                 const std::map<std::string, std::string>& refused) {
  std::vector<Setting> settings;
  for (const auto& [name, asked] : wanted) settings.push_back(judged(name, asked, after, refused));
  for (const char* name : kRecorded) {
    const auto found = after.find(name);
    if (found != after.end() && !wanted.contains(name))
      settings.push_back({name, "", found->second.value, SettingState::read, ""});
  }
  return settings;
}

}  // namespace strobe::gphoto2
