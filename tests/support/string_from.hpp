// CppUTest with a CHECK_EQUAL that prints what it compares, where CppUTest itself cannot: optionals, enums by their
// names, times, ranges, pairs and whatever has an operator<<.
#pragma once

#include <CppUTest/TestHarness.h>

#include <array>
#include <chrono>
#include <concepts>
#include <optional>
#include <ranges>
#include <sstream>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

namespace strobe::testing {

template <typename Enum, Enum value>
constexpr std::string_view spelled() {
  // "... [with Enum = E; Enum value = E::name; ...]", or "(E)7" without a name; "[Enum = E, value = E::name]" by clang,
  // where E may begin with "(anonymous namespace)::".
  return __PRETTY_FUNCTION__;
}

/// The enumerator's name, or its number. Names are known for values 0 to 63.
template <typename Enum>
std::string enum_text(Enum value) {
  const auto number = static_cast<long long>(value);
  const auto names = []<std::size_t... i>(std::index_sequence<i...>) {
    return std::array{spelled<Enum, static_cast<Enum>(i)>()...};
  }
  (std::make_index_sequence<64>{});
  if (number < 0 || number >= static_cast<long long>(names.size())) return std::to_string(number);
  std::string_view text = names[static_cast<std::size_t>(number)];
  text = text.substr(text.find("value = ") + 8);
  text = text.substr(0, text.find_first_of(";]"));
  const std::size_t cast = text.rfind(')');
  if (cast != text.npos && text[cast + 1] != ':') return std::to_string(number);
  return std::string(text.substr(text.rfind(':') + 1));
}

template <typename T>
std::string text_of(const T& value);

template <typename Range>
std::string range_text(const Range& range) {
  std::string text;
  for (const auto& each : range) text += (text.empty() ? "" : ", ") + text_of(each);
  return "{" + text + "}";
}

template <typename T>
concept Streamable = requires(std::ostream& stream, const T& value) {
  stream << value;
};

template <typename T>
constexpr bool is_optional = false;
template <typename T>
constexpr bool is_optional<std::optional<T>> = true;

/// Empty optionals are "none", times are in nanoseconds.
template <typename T>
std::string text_of(const T& value) {
  if constexpr (std::is_enum_v<T>) {
    return enum_text(value);
  } else if constexpr (is_optional<T>) {
    return value ? text_of(*value) : "none";
  } else if constexpr (std::convertible_to<T, std::chrono::nanoseconds>) {
    return std::to_string(std::chrono::nanoseconds(value).count()) + " ns";
  } else if constexpr (requires { value.time_since_epoch(); }) {
    return text_of(value.time_since_epoch());
  } else if constexpr (Streamable<T>) {
    std::ostringstream stream;
    stream.precision(17);
    stream << value;
    return stream.str();
  } else if constexpr (std::ranges::input_range<const T>) {
    return range_text(value);
  } else if constexpr (requires { value.first, value.second; }) {
    return "(" + text_of(value.first) + ", " + text_of(value.second) + ")";
  } else {
    return "(a value without a text)";
  }
}

/// What CppUTest's own overloads do not print.
template <typename T>
concept PrintedHere = std::is_class_v<T> || std::is_enum_v<T>;

}  // namespace strobe::testing

template <strobe::testing::PrintedHere T>
requires(!std::same_as<T, std::string> && !std::same_as<T, SimpleString>) SimpleString
    StringFrom(const T& value) {
  return SimpleString(strobe::testing::text_of(value).c_str());
}
