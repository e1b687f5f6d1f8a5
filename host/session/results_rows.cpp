#include "host/session/results_rows.hpp"

#include <algorithm>
#include <charconv>
#include <optional>

#include "common/config/files.hpp"

namespace strobe::host {
namespace {

/// Up to the next line's end outside quotes, which `text` then follows.
std::optional<std::string_view> take_line(std::string_view& text) {
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '"') quoted = !quoted;
    if (text[i] != '\n' || quoted) continue;
    const std::string_view line = text.substr(0, i);
    text.remove_prefix(i + 1);
    return line;
  }
  return std::nullopt;
}

std::string_view take_field(std::string_view& line) {
  const std::size_t comma = line.find(',');
  const std::string_view field = line.substr(0, comma);
  line.remove_prefix(comma == std::string_view::npos ? line.size() : comma + 1);
  return field;
}

template <typename Number>
std::optional<Number> number(std::string_view text, int base) {
  Number value{};
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value, base);
  if (text.empty() || read.ec != std::errc() || read.ptr != text.data() + text.size()) return std::nullopt;
  return value;
}

/// Unless it is none.
void add_row(std::string_view line, std::vector<ResultsRow>& rows) {
  std::string_view rest = line;
  const std::string_view utc = take_field(rest);
  const auto boot = number<std::uint64_t>(take_field(rest), 16);
  const auto shot = number<std::int32_t>(take_field(rest), 10);
  const bool counts = rest.empty() || rest.front() == ',';  // the reason, else
  if (boot && shot)
    rows.push_back({{static_cast<std::int64_t>(*boot), *shot}, std::string(utc), counts, std::string(line)});
}

}  // namespace

std::vector<ResultsRow> parse_results(std::string_view text) {
  std::vector<ResultsRow> rows;
  while (const auto line = take_line(text)) add_row(*line, rows);
  return rows;
}

Result<std::vector<ResultsRow>> read_results_rows(const std::filesystem::path& file) {
  std::vector<ResultsRow> rows;
  std::string begun;
  bool whole = true;
  const auto read = config::read_lines(file, [&](std::string_view line, bool ended) {
    if (begun.size() > config::kMaxLine_bytes) whole = false;
    if (!ended || !whole) return;
    begun += line;
    if (std::ranges::count(begun, '"') % 2 != 0) {  // a quoted field goes on
      begun += '\n';
      return;
    }
    add_row(begun, rows);
    begun.clear();
  });
  if (!read) return tl::unexpected(read.error());
  if (!whole) return fail(file.string() + ": a quoted field has no end");
  return rows;
}

}  // namespace strobe::host
