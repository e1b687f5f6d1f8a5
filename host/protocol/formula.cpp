#include "host/protocol/formula.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <utility>

#include "host/protocol/expression.hpp"

namespace strobe::protocol {
namespace {

using Kind = Expression::Kind;

constexpr std::size_t kMaxFormulaLength = 1000;
constexpr int kMaxFormulaDepth = 60;

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Recursive descent:
///   sum = product {("+" | "-") product};  product = signed {("*" | "/") signed};
///   signed = ["-" | "+"] signed | power;  power = atom ["^" signed];
///   atom = number | name | name "(" sum {"," sum} ")" | "'" text "'" | "(" sum ")".
class FormulaParser {
 public:
  explicit FormulaParser(std::string_view text) : text_(text) {}

  Result<Expression> run() {
    if (text_.size() > kMaxFormulaLength)
      return fail(fmt::format("is longer than {} characters", kMaxFormulaLength));
    Expression all = sum();
    if (!wrong_.empty()) return fail(wrong_);
    if (peek() != '\0') return fail(complaint("an operator is missing"));
    return all;
  }

 private:
  std::string complaint(std::string_view what) const {
    return fmt::format("at character {}: {}", at_ + 1, what);
  }

  /// The first stays; what follows comes to its end without reading further.
  Expression refuse(std::string_view what) {
    if (wrong_.empty()) wrong_ = complaint(what);
    at_ = text_.size();
    return {};
  }

  char peek() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\n')) ++at_;
    return at_ < text_.size() ? text_[at_] : '\0';
  }

  bool take(char c) {
    if (peek() != c || c == '\0') return false;
    ++at_;
    return true;
  }

  Expression join(Kind kind, std::size_t at, Expression left, Expression right) {
    Expression both{.kind = kind, .at = at};
    both.arguments.push_back(std::move(left));
    both.arguments.push_back(std::move(right));
    return both;
  }

  Expression sum() {
    if (++depth_ > kMaxFormulaDepth) return refuse("too many parentheses");
    Expression left = product();
    for (char c = peek(); c == '+' || c == '-'; c = peek()) {
      const std::size_t at = ++at_;
      left = join(c == '+' ? Kind::add : Kind::subtract, at, std::move(left), product());
    }
    --depth_;
    return left;
  }

  Expression product() {
    Expression left = with_sign();
    for (char c = peek(); c == '*' || c == '/'; c = peek()) {
      const std::size_t at = ++at_;
      left = join(c == '*' ? Kind::multiply : Kind::divide, at, std::move(left), with_sign());
    }
    return left;
  }

  Expression with_sign() {
    if (++depth_ > kMaxFormulaDepth) return refuse("too many signs");
    Expression value;
    if (take('-')) {
      value = {.kind = Kind::negate, .at = at_};
      value.arguments.push_back(with_sign());
    } else {
      value = take('+') ? with_sign() : power();
    }
    --depth_;
    return value;
  }

  Expression power() {
    Expression base = atom();
    if (!take('^')) return base;
    const std::size_t at = at_;
    return join(Kind::power, at, std::move(base), with_sign());
  }

  Expression atom() {
    const char c = peek();
    if (is_digit(c) || c == '.') return number();
    if (is_letter(c)) return name();
    if (c == '\'') return quoted();
    if (take('(')) {
      Expression inner = sum();
      if (!take(')')) return refuse("a closing parenthesis is missing");
      return inner;
    }
    return refuse(c == '\0' ? "a number or a name is missing" : "must be a number, a name or a parenthesis");
  }

  Expression number() {
    Expression value{.at = at_ + 1};
    const char* const begin = text_.data() + at_;
    const auto [end, error] = std::from_chars(begin, text_.data() + text_.size(), value.number);
    if (error != std::errc() || !std::isfinite(value.number)) return refuse("is no number");
    at_ += static_cast<std::size_t>(end - begin);
    return value;
  }

  Expression name() {
    Expression value{.kind = Kind::name, .at = at_ + 1};
    while (at_ < text_.size() && (is_letter(text_[at_]) || is_digit(text_[at_]))) value.name += text_[at_++];
    if (!take('(')) return value;
    value.kind = Kind::call;
    do value.arguments.push_back(sum());
    while (take(','));
    if (!take(')')) return refuse("a closing parenthesis is missing");
    return value;
  }

  Expression quoted() {
    Expression value{.kind = Kind::text, .at = at_ + 1};
    const std::size_t end = text_.find('\'', at_ + 1);
    if (end == text_.npos) return refuse("a closing ' is missing");
    value.name = text_.substr(at_ + 1, end - at_ - 1);
    at_ = end + 1;
    return value;
  }

  std::string_view text_;
  std::size_t at_ = 0;
  int depth_ = 0;
  std::string wrong_;
};

}  // namespace

Result<Formula> parse_formula(std::string_view text) {
  auto parsed = FormulaParser(text).run();
  if (!parsed) return tl::unexpected(parsed.error());
  return Formula{std::string(text), std::make_shared<const Expression>(std::move(*parsed))};
}

}  // namespace strobe::protocol
