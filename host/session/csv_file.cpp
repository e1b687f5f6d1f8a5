#include "host/session/csv_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>

#include "common/config/files.hpp"

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

/// What of a file tells how it goes on.
struct Ends {
  std::string first;                ///< line, without its end
  std::optional<std::string> last;  ///< if it has no end
  off_t size = 0;
};

Result<Ends> ends_of(const std::filesystem::path& path) {
  std::optional<std::string> first;
  Ends ends;
  const auto read = config::read_lines(path, [&](std::string_view line, bool ended) {
    if (!first) first = line;
    if (!ended) ends.last = line;
    ends.size += static_cast<off_t>(line.size() + (ended ? 1 : 0));
  });
  if (!read) return tl::unexpected(read.error());
  ends.first = std::move(first).value_or("");
  return ends;
}

/// full: the number of columns.
Result<void> mend(RecordFile& file, const Ends& ends, std::ptrdiff_t full) {
  if (!ends.last) return {};
  if (columns(*ends.last) == full) return file.append("\n", "line's end");
  if (file.cut(ends.size - static_cast<off_t>(ends.last->size()), ends.size)) return {};
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
  const auto ends = ends_of(path);
  if (!ends) return tl::unexpected(ends.error());
  const std::string& first = ends->first;
  // Cut short, or not yet written.
  const bool is_earlier = std::ranges::find(earlier, first) != earlier.end();
  const bool unfinished =
      static_cast<off_t>(first.size()) == ends->size && header.starts_with(first) && !is_earlier;
  if (!unfinished && first != header && !is_earlier)
    return fail(path.string() + ":1: another version's columns; use another session folder");
  if (unfinished) {
    if (!file->cut(0, ends->size))
      return fail(path.string() + ": cannot be written: " + std::strerror(errno));
    if (auto written = file->append(header + "\n", "header"); !written)
      return tl::unexpected(written.error());
    return CsvFile(std::move(*file), 0);
  }
  if (auto mended = mend(*file, *ends, columns(first)); !mended) return tl::unexpected(mended.error());
  return CsvFile(std::move(*file), columns(header) - columns(first));
}

Result<void> CsvFile::append(const std::string& line) {
  std::string kept = line;
  for (std::ptrdiff_t i = 0; i < left_out_; ++i) kept.resize(kept.rfind(','));
  return file_.append(kept + "\n", "lines");
}

}  // namespace strobe::host
