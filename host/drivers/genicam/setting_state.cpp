#include "host/drivers/genicam/setting_state.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <optional>

namespace strobe::genicam {
namespace {

using tether::Setting;
using tether::SettingState;

std::optional<double> number_of(const std::string& text) {
  double number = 0.0;
  const char* end = text.data() + text.size();
  const auto [at, fault] = std::from_chars(text.data(), end, number);
  if (fault != std::errc{} || at != end) return std::nullopt;
  return number;
}

bool is_number(Kind kind) { return kind == Kind::number || kind == Kind::integer; }

}  // namespace

bool is_same(Kind kind, const std::string& asked, const std::string& is) {
  if (asked == is) return true;
  if (kind == Kind::boolean) {
    const std::string first = asked.substr(0, 1);
    const bool off = asked == "off" || asked == "Off" || first == "0" || first == "f" || first == "F";
    return (is == "false") == off;
  }
  const auto a = number_of(asked), b = number_of(is);
  // A float of 32 bits is no rounding of the camera's.
  return is_number(kind) && a && b && std::abs(*a - *b) <= 1e-6 * std::abs(*a);
}

Setting judged(const std::string& name, Kind kind, const std::string& asked, const std::string& before,
               const std::string& is, const std::string& refusal) {
  Setting setting{name, asked, is, SettingState::as_asked, ""};
  if (is_same(kind, asked, is)) return setting;
  const auto a = number_of(asked), b = number_of(is);
  const bool near = is_number(kind) && a && b && std::abs(*a - *b) <= 0.05 * std::abs(*a);
  if (near || (refusal.empty() && is_number(kind) && a && b && is != before)) {
    setting.state = SettingState::rounded;
    setting.remark = fmt::format("by {:+.3g}", *b - *a);
    return setting;
  }
  setting.state = SettingState::refused;
  setting.remark = refusal.empty() ? "the camera said nothing" : refusal;
  return setting;
}

}  // namespace strobe::genicam
