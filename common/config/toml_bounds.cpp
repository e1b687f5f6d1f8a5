#include "common/config/toml_bounds.hpp"

#include <algorithm>
#include <string>

namespace strobe::config {
namespace {

/// Goes through the text as the parser does as long as that finds no error; what comes after one is never
/// parsed.
class Walk {
 public:
  explicit Walk(std::string_view text) : rest_(text) {
    if (rest_.starts_with("\xEF\xBB\xBF")) rest_.remove_prefix(3);  // the mark of UTF-8
  }

  std::optional<Error> problem() {
    while (!rest_.empty() && parts_ <= kMaxKeyParts && open_ <= kMaxOpenBrackets && stray_.empty()) step();
    if (!stray_.empty()) return at_line("a character beyond ASCII stands " + std::string(stray_));
    if (parts_ > kMaxKeyParts)
      return at_line("a key of more than " + std::to_string(kMaxKeyParts) + " parts");
    if (open_ > kMaxOpenBrackets)
      return at_line("more than " + std::to_string(kMaxOpenBrackets) + " brackets within each other");
    return std::nullopt;
  }

 private:
  void step() {
    const char c = rest_.front();
    if (beyond_ascii(c)) stray_ = "neither in quotes nor in a comment";
    if (c == '"' || c == '\'') return pass_string(c);
    if (c == '#') return pass(std::min(rest_.find('\n'), rest_.size()));
    if (c == '.') ++parts_;
    if (c == '[' || c == '{') ++open_;
    if (c == ']' || c == '}') open_ = std::max(0, open_ - 1);
    if (std::string_view("[]{},=\n").find(c) != std::string_view::npos) parts_ = 1;
    pass(1);
  }

  void pass_string(char quote) {
    const std::string three(3, quote);
    if (!rest_.starts_with(three)) return pass_until(std::string_view(&quote, 1), quote);
    pass(3);
    pass_until(three, quote);
    for (int i = 0; i < 2 && rest_.starts_with(quote); ++i) pass(1);  // the last ones of its text
  }

  /// A string on one line begins with the quote that ends it, and ends with its line, which the parser takes
  /// as an error.
  void pass_until(std::string_view end, char quote) {
    const bool one_line = end.size() == 1;
    if (one_line) pass(1);
    while (!rest_.empty() && !rest_.starts_with(end) && !(one_line && rest_.front() == '\n')) {
      const bool escaped = quote == '"' && rest_.front() == '\\';
      if (escaped && follows_backslash()) {
        stray_ = "behind a backslash";
        return;
      }
      pass(escaped ? 2 : 1);
    }
    if (rest_.starts_with(end)) pass(end.size());
  }

  /// The parser looks for blanks there, too: a backslash at the end of a line joins it to the next.
  bool follows_backslash() const {
    const std::size_t next = rest_.find_first_not_of(" \t\r\n", 1);
    return next != std::string_view::npos && beyond_ascii(rest_[next]);
  }

  void pass(std::size_t size) {
    const std::string_view passed = rest_.substr(0, size);
    line_ += std::ranges::count(passed, '\n');
    rest_.remove_prefix(passed.size());
  }

  static bool beyond_ascii(char c) { return static_cast<unsigned char>(c) >= 0x80; }

  Error at_line(const std::string& what) const { return {std::to_string(line_) + ": " + what}; }

  std::string_view rest_;
  std::ptrdiff_t line_ = 1;
  int parts_ = 1, open_ = 0;
  std::string_view stray_;  ///< where a character beyond ASCII stands that may not; empty: nowhere
};

}  // namespace

std::optional<Error> toml_bounds_problem(std::string_view text) {
  if (text.size() > kMaxToml_bytes)
    return Error{"1: larger than " + std::to_string(kMaxToml_bytes >> 20) + " MB"};
  return Walk(text).problem();
}

}  // namespace strobe::config
