#include "common/units/tolerance.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <optional>

namespace strobe {

namespace {

constexpr std::string_view kBlanks = " \t";
constexpr std::size_t kLongest = 40;

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

/// The text on one line, at a length that a line has room for.
std::string quoted(std::string_view text) {
  std::string shown = "'";
  for (const char c : text.substr(0, kLongest)) shown += (c >= ' ' && c <= '~') ? c : '?';
  return shown.append(text.size() > kLongest ? "...'" : "'");
}

/// A decimal number times 10^-shift. The shift goes into the exponent, so that the nearest double results as
/// if it had been written so.
std::optional<double> number(std::string_view text, int shift) {
  const auto e = text.find_first_of("eE");
  int exponent = 0;
  if (e != std::string_view::npos) {
    std::string_view digits = text.substr(e + 1);
    if (digits.starts_with('+') && !digits.starts_with("+-")) digits.remove_prefix(1);
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), exponent);
    if (error != std::errc{} || end != digits.data() + digits.size()) return std::nullopt;
    if (std::abs(exponent) > 1'000'000) return std::nullopt;
  }
  const std::string shifted = std::string(text.substr(0, e)) + "e" + std::to_string(exponent - shift);
  double value = 0.0;
  const auto [end, error] = std::from_chars(shifted.data(), shifted.data() + shifted.size(), value);
  if (error != std::errc{} || end != shifted.data() + shifted.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

}  // namespace

Result<double> parse_tolerance(std::string_view text) {
  std::string_view digits = trimmed(text);
  const bool percent = digits.ends_with('%');
  if (percent) digits = trimmed(digits.substr(0, digits.size() - 1));
  const auto value = number(digits, percent ? 2 : 0);
  if (!value) return fail(quoted(text) + " is not a tolerance; write one as 0.5% or 5e-3");
  if (!(*value > 0.0)) return fail(quoted(text) + " is not a tolerance: it must be above 0");
  if (*value > kLargestTolerance) {
    std::string what = quoted(text) + " is more than 100%";
    if (!percent && *value <= 100.0) what.append("; did you mean ").append(digits).append("%?");
    return fail(std::move(what));
  }
  return *value;
}

std::string tolerance_text(double tolerance) {
  std::array<char, 32> plain{};
  const auto [end, error] =
      std::to_chars(plain.data(), plain.data() + plain.size(), tolerance, std::chars_format::scientific);
  if (error != std::errc{}) return "?";
  // d.dddde-NN: its digits stay, two more in the exponent make it a percentage.
  const std::string_view text(plain.data(), static_cast<std::size_t>(end - plain.data()));
  const auto e = text.find('e');
  const int exponent = std::stoi(std::string(text.substr(e + 1))) + 2;
  std::string digits(text.substr(0, 1));
  if (e > 2) digits.append(text.substr(2, e - 2));
  std::size_t whole = 1;
  if (exponent >= 0) whole += static_cast<std::size_t>(exponent);
  if (exponent < 0 && exponent >= -4) digits = std::string(static_cast<std::size_t>(-exponent), '0') + digits;
  if (digits.size() < whole) digits.append(whole - digits.size(), '0');
  std::string out = digits.substr(0, whole);
  if (digits.size() > whole) out.append(".").append(digits, whole);
  if (exponent < -4) out.append("e").append(std::to_string(exponent));
  return out + "%";
}

}  // namespace strobe
