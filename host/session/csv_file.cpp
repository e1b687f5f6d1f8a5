#include "host/session/csv_file.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <optional>

namespace strobe::host {
namespace {

std::ptrdiff_t columns(std::string_view line) {
  bool quoted = false;
  std::ptrdiff_t count = 1;
  for (const char c : line) {
    if (c == '"') quoted = !quoted;
    if (c == ',' && !quoted) ++count;
  }
  return count;
}

Result<std::string> read_all(const RecordFile& file) {
  std::string text;
  std::array<char, 65536> block{};
  while (true) {
    const ssize_t size = ::pread(file.fd(), block.data(), block.size(), static_cast<off_t>(text.size()));
    if (size < 0 && errno == EINTR) continue;
    if (size < 0) return fail(file.path().string() + ": " + std::strerror(errno));
    if (size == 0) return text;
    text.append(block.data(), static_cast<std::size_t>(size));
  }
}

/// The last line, if it has no end.
std::optional<std::string> torn_line(const std::string& text) {
  if (text.empty() || text.back() == '\n') return std::nullopt;
  return text.substr(text.rfind('\n') + 1);  // npos + 1: all of it
}

/// full: the number of columns.
Result<void> mend(RecordFile& file, const std::string& text, std::ptrdiff_t full) {
  const auto torn = torn_line(text);
  if (!torn) return {};
  const auto size = static_cast<off_t>(text.size());
  if (columns(*torn) == full) return file.append("\n", "line's end");
  if (file.cut(size - static_cast<off_t>(torn->size()), size)) return {};
  return fail(file.path().string() + ": a torn line cannot be removed: " + std::strerror(errno));
}

}  // namespace

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"') result += '"';
    result += c;
  }
  return result + "\"";
}

std::vector<std::string> csv_fields(std::string_view line) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const bool quote = line[i] == '"';
    if (quote && quoted && i + 1 < line.size() && line[i + 1] == '"')
      cells.back() += line[i++];
    else if (quote)
      quoted = !quoted;
    else if (line[i] == ',' && !quoted)
      cells.emplace_back();
    else
      cells.back() += line[i];
  }
  return cells;
}

Result<CsvFile> CsvFile::open(const std::filesystem::path& path, const std::string& header,
                              const std::vector<std::string>& earlier) {
  auto file = RecordFile::open(path, RecordFile::Use::append);
  if (!file) return tl::unexpected(file.error());
  const auto text = read_all(*file);
  if (!text) return tl::unexpected(text.error());
  std::string first = text->substr(0, text->find('\n'));
  // Cut short, or not yet written.
  const bool is_earlier = std::ranges::find(earlier, first) != earlier.end();
  const bool unfinished = first.size() == text->size() && header.starts_with(first) && !is_earlier;
  if (!unfinished && first != header && !is_earlier)
    return fail(path.string() + ":1: another version's columns; use another session folder");
  if (unfinished) {
    if (!file->cut(0, static_cast<off_t>(text->size())))
      return fail(path.string() + ": cannot be written: " + std::strerror(errno));
    if (auto written = file->append(header + "\n", "header"); !written)
      return tl::unexpected(written.error());
    return CsvFile(std::move(*file), 0);
  }
  if (auto mended = mend(*file, *text, columns(first)); !mended) return tl::unexpected(mended.error());
  return CsvFile(std::move(*file), columns(header) - columns(first));
}

Result<void> CsvFile::append(const std::string& line) {
  std::string kept = line;
  for (std::ptrdiff_t i = 0; i < left_out_; ++i) kept.resize(kept.rfind(','));
  return file_.append(kept + "\n", "lines");
}

}  // namespace strobe::host
