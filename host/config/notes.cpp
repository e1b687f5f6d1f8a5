#include "host/config/notes.hpp"

#include <charconv>
#include <cmath>

#include "common/messages/record.hpp"

namespace strobe::host {
namespace {

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

/// Bytes of the UTF-8 sequence at the front, 0 if there is none. Overlong forms and surrogates are refused
/// (RFC 3629).
std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return 0;
  }
  if (first == 0xE0 && byte(1) < 0xA0) return 0;
  if (first == 0xED && byte(1) > 0x9F) return 0;
  if (first == 0xF0 && byte(1) < 0x90) return 0;
  if (first == 0xF4 && byte(1) > 0x8F) return 0;
  return length;
}

bool valid_text(std::string_view text) {
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    if (length == 0) return false;
    const auto first = static_cast<unsigned char>(text.front());
    if (first < 0x20 || first == 0x7F) return false;
    text.remove_prefix(length);
  }
  return true;
}

}  // namespace

std::optional<std::string> note_problem(std::string_view key, std::string_view value) {
  if (!messages::valid_note_key(key)) {
    return "note \"" + std::string(key) + "\": a key is 1 to 64 of a-z, 0-9, underscore and dot";
  }
  if (value.size() > messages::kLongestNoteValue)
    return "note " + std::string(key) + ": longer than 1024 bytes";
  if (!valid_text(value)) return "note " + std::string(key) + ": not plain UTF-8 text on one line";
  return std::nullopt;
}

Result<void> add_note(reduction::Record& record, std::string_view text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string_view::npos) {
    return fail("note \"" + std::string(text) + "\": must be key=value");
  }
  const std::string key(trimmed(text.substr(0, equals)));
  const std::string value(trimmed(text.substr(equals + 1)));
  if (const auto problem = note_problem(key, value)) return fail(*problem);
  if (!record.contains(key) && record.size() >= messages::kMaxNotes)
    return fail("note " + key + ": more than 64 notes");
  record[key] = value;
  return {};
}

std::optional<double> note_number(const reduction::Record& record, std::string_view key) {
  const auto entry = record.find(std::string(key));
  if (entry == record.end()) return std::nullopt;
  const std::string_view text = trimmed(entry->second);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace strobe::host
