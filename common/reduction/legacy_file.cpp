#include "common/reduction/legacy_file.hpp"

#include <charconv>
#include <cmath>
#include <optional>
#include <span>

namespace strobe::reduction {
namespace {

constexpr double kLongestPeriodS = 1.0;
constexpr int kMaxContact = 1000;

struct Line {
  std::size_t number = 0;
  std::string_view text;  // without surrounding blanks
  bool blank() const { return text.empty(); }
};

constexpr std::string_view kBlanks = " \t\r\v\f";

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

std::vector<Line> split_lines(std::string_view text) {
  std::vector<Line> lines;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    lines.push_back({lines.size() + 1, trimmed(text.substr(0, end))});
    text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
  }
  return lines;
}

/// Frames end at two blank lines. A block starts with a line that is not blank and ends with one.
std::vector<std::span<const Line>> split_frames(std::span<const Line> lines) {
  std::vector<std::span<const Line>> blocks;
  std::size_t begin = 0;
  std::size_t end = 0;  // after the last line that is not blank
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (lines[i].blank()) continue;
    if (end > begin && i - end >= 2) {
      blocks.push_back(lines.subspan(begin, end - begin));
      begin = i;
    }
    if (end <= begin) begin = i;
    end = i + 1;
  }
  if (end > begin) blocks.push_back(lines.subspan(begin, end - begin));
  return blocks;
}

template <typename T>
std::optional<T> take(std::string_view& text) {
  text = trimmed(text);
  if (text.starts_with('+')) text.remove_prefix(1);
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc()) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  if (!text.empty() && kBlanks.find(text.front()) == std::string_view::npos) return std::nullopt;
  return value;
}

/// Reads the lines of one frame; remembers the first error.
class FrameReader {
 public:
  FrameReader(std::span<const Line> lines, const std::string& file_name)
      : lines_(lines), file_name_(file_name) {}

  Result<LegacyFrame> read(double period_s) {
    LegacyFrame frame;
    frame.period_s = period_s;
    header(frame);
    for (std::size_t i = 0; i < 4; ++i) frame.surface[i] = point("surface point", i + 1);
    for (std::size_t i = 0; i < 6; ++i) frame.flight[i] = image(i + 1);
    const std::size_t contact = frame.contact_count == 1 ? 1 : 2;
    for (std::size_t i = 0; i < contact; ++i) frame.contact.push_back(image(7 + i));
    if (next_ < lines_.size())
      wrong(lines_[next_].number, "the frame has more lines than " + std::to_string(6 + contact) + " images");
    if (!error_.empty()) return fail(error_);
    return frame;
  }

 private:
  void wrong(std::size_t line, const std::string& what) {
    if (error_.empty()) error_ = file_name_ + ":" + std::to_string(line) + ": " + what;
  }

  std::optional<Line> line(const std::string& wanted) {
    if (!error_.empty()) return std::nullopt;
    if (next_ < lines_.size()) return lines_[next_++];
    wrong(lines_.back().number, "the frame ends where " + wanted + " should follow");
    return std::nullopt;
  }

  void header(LegacyFrame& frame) {
    const auto l = line("its contact count");
    if (!l) return;
    std::string_view rest = l->text;
    const auto count = take<int>(rest);
    const auto number = count ? take<int>(rest) : std::nullopt;
    if (!count || !number || !rest.empty())
      return wrong(l->number, "must be two whole numbers: contact count, frame number");
    if (*count < 1 || *count > kMaxContact)
      return wrong(l->number, "the contact count must be from 1 to 1000");
    frame.contact_count = *count;
    frame.frame_number = *number;
  }

  PointPx point(const char* what, std::size_t index) {
    const std::string name = std::string(what).append(1, ' ').append(std::to_string(index));
    const auto l = line(name);
    if (!l) return {};
    std::string_view rest = l->text;
    const auto x = take<double>(rest);
    const auto y = x ? take<double>(rest) : std::nullopt;
    const bool good = x && y && rest.empty() && std::isfinite(*x) && std::isfinite(*y);
    if (!good) wrong(l->number, name + " must be two finite numbers");
    return good ? PointPx{*x, *y} : PointPx{};
  }

  LegacyImage image(std::size_t index) {
    const auto blank = line("a blank line and image " + std::to_string(index));
    if (blank && !blank->blank())
      wrong(blank->number, "a blank line must come before image " + std::to_string(index));
    LegacyImage result;
    result.centre = point("centre of image", index);
    const std::size_t edge_line = next_;
    result.edge = point("edge point of image", index);
    result.equator_1 = point("first equator point of image", index);
    result.equator_2 = point("second equator point of image", index);
    if (!error_.empty()) return result;
    const auto same = [](PointPx a, PointPx b) { return a.x == b.x && a.y == b.y; };
    if (same(result.centre, result.edge))
      wrong(lines_[edge_line].number, "the edge point of image " + std::to_string(index) + " is its centre");
    if (same(result.equator_1, result.equator_2))
      wrong(lines_[edge_line + 2].number,
            "the equator points of image " + std::to_string(index) + " are one point");
    return result;
  }

  std::span<const Line> lines_;
  const std::string& file_name_;
  std::size_t next_ = 0;
  std::string error_;
};

}  // namespace

std::vector<Result<LegacyFrame>> parse_legacy(std::string_view text, const std::string& file_name) {
  const std::vector<Line> lines = split_lines(text);
  if (lines.empty())
    return {fail(file_name + ":1: the file is empty; line 1 must be the strobe period in seconds")};
  std::string_view rest = lines.front().text;
  const auto period = take<double>(rest);
  if (!period || !rest.empty() || !(*period > 0.0 && *period <= kLongestPeriodS)) {
    return {fail(file_name + ":1: must be the strobe period in seconds, above 0 and at most 1")};
  }
  std::vector<Result<LegacyFrame>> frames;
  for (const auto& block : split_frames(std::span(lines).subspan(1))) {
    frames.push_back(FrameReader(block, file_name).read(*period));
  }
  if (frames.empty()) frames.push_back(fail(file_name + ":1: no frame follows"));
  return frames;
}

}  // namespace strobe::reduction
