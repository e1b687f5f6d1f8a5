#include "host/protocol/protocol.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "common/config/files.hpp"
#include "common/config/nearest.hpp"
#include "common/config/toml_reader.hpp"
#include "host/protocol/formula_check.hpp"

namespace strobe::protocol {
namespace {

using config::Range;
using config::TomlReader;
using config::TomlTable;

constexpr Range kCount{1, 1000}, kNoneOrMore{0, 1000};
constexpr Range kSpeed_mps{0.1, 150}, kAngle_deg{1, 90}, kSpin_radps{-2000, 2000}, kHeight_m{0.02, 20};

/// As a formula writes it.
bool is_name(std::string_view text) {
  const auto inner = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  };
  return !text.empty() && std::ranges::all_of(text, inner) && !(text[0] >= '0' && text[0] <= '9');
}

bool has_text(std::string_view text) { return text.find_first_not_of(" \t\n") != text.npos; }

/// Takes a file apart, table by table; what was read before is known to what follows.
class ProtocolReader {
 public:
  explicit ProtocolReader(TomlTable root) : root_(std::move(root)) {}

  Protocol run() {
    read_.title = required_text(root_, "title");
    source(root_.table("source"));
    test(root_.table("test"));
    impact(root_.table("impact"));
    for (TomlTable& t : root_.tables("input")) input(t);
    for (TomlTable& t : root_.tables("conforms")) conforms(t);
    for (TomlTable& t : root_.tables("computed")) computed(t);
    for (TomlTable& t : root_.tables("requirement")) requirement(t);
    TomlTable report = root_.table("report");
    read_.preparation = report.strings_or("preparation", {});
    read_.not_measured = report.strings_or("not_measured", {});
    read_.report = report.string_or("text", "");
    return std::move(read_);
  }

 private:
  std::string required_text(TomlTable& t, std::string_view key) {
    std::string text = t.string(key);
    if (t.has(key) && !has_text(text)) t.error_at(key, "must not be empty");
    return text;
  }

  Interval interval(TomlTable& t) {
    Interval all;
    all.low = t.number_or("least", all.low);
    all.high = t.number_or("most", all.high);
    if (all.low > all.high) t.error_at("most", "must not be below least");
    return all;
  }

  Interval required_interval(TomlTable& t) {
    if (!t.has("least") && !t.has("most")) t.error_at("least", "is missing, or most");
    return interval(t);
  }

  void source(TomlTable t) {
    read_.source.document = required_text(t, "document");
    read_.source.edition = t.string_or("edition", "");
    if (!t.has("read")) t.error_at("read", "is missing");
    const std::string read = t.choice_or("read", "not_read", {"whole", "summary", "not_read"});
    read_.source.read = read == "whole"     ? SourceRead::whole
                        : read == "summary" ? SourceRead::summary
                                            : SourceRead::not_read;
    read_.source.where = read == "whole" ? t.string_or("where", "") : required_text(t, "where");
  }

  void test(TomlTable t) {
    read_.ball_kind = t.string_or("ball_kind", "");
    read_.balls = static_cast<int>(t.integer_or("balls", 1, kCount));
    read_.positions = t.strings_or("positions", {"1"});
    if (read_.positions.empty()) t.error_at("positions", "must name one at least");
    for (auto p = read_.positions.begin(); p != read_.positions.end(); ++p) {
      if (!has_text(*p) || p->find('\'') != p->npos)
        t.error_at("positions", "must be names without quotation marks");
      if (std::find(read_.positions.begin(), p, *p) != p) t.error_at("positions", "has \"" + *p + "\" twice");
    }
    read_.repeats = static_cast<int>(t.integer("repeats", kCount));
    read_.discarded = static_cast<int>(t.integer_or("discarded", 0, kNoneOrMore));
    read_.drawn_order = t.choice_or("order", "listed", {"listed", "drawn"}) == "drawn";
    read_.replacements = static_cast<int>(t.integer_or("replacements", 0, kNoneOrMore));
  }

  void impact(TomlTable t) {
    if (!t.has("kind")) t.error_at("kind", "is missing");
    NominalImpact& impact = read_.impact;
    if (t.choice_or("kind", "thrown", {"thrown", "dropped"}) == "dropped") {
      impact.kind = ImpactKind::dropped;
      impact.drop_height_m = t.number("drop_height_m", kHeight_m);
      return;
    }
    impact.speed_mps = t.number("speed_mps", kSpeed_mps);
    impact.angle_deg = t.number("angle_deg", kAngle_deg);
    impact.spin_radps = t.number_or("spin_radps", 0.0, kSpin_radps);
  }

  /// A name that a formula can say, and that nothing else has.
  std::string new_name(TomlTable& t) {
    std::string name = t.string("name");
    if (!t.has("name")) return name;
    if (!is_name(name)) t.error_at("name", "must be letters, digits and _, a letter first");
    if (is_known(read_, name)) t.error_at("name", "\"" + name + "\" is there already");
    return name;
  }

  void input(TomlTable& t) {
    Input input{.name = new_name(t)};
    input.unit = t.string_or("unit", "");
    input.words = required_text(t, "words");
    input.sd = t.number("sd", {0, 1e9});
    input.value = t.optional_number("value");
    input.allowed = interval(t);
    if (input.value && !(*input.value >= input.allowed.low && *input.value <= input.allowed.high))
      t.error_at("value", "must be from least to most");
    read_.inputs.push_back(std::move(input));
  }

  void conforms(TomlTable& t) {
    Conformance c{t.string("quantity"), required_interval(t)};
    if (t.has("quantity") && !is_known(read_, c.quantity))
      t.error_at("quantity",
                 "no such quantity or input" + config::did_you_mean(c.quantity, known_names(read_)));
    read_.conforms.push_back(std::move(c));
  }

  void computed(TomlTable& t) {
    Computed c{.name = new_name(t)};
    c.words = required_text(t, "words");
    c.unit = t.string_or("unit", "");
    const std::string level = t.choice_or("level", "shot", {"shot", "ball", "position", "test"});
    c.level = level == "shot"       ? Level::shot
              : level == "ball"     ? Level::ball
              : level == "position" ? Level::position
                                    : Level::test;
    if (!t.has("level")) t.error_at("level", "is missing");
    const std::string text = t.string("formula");
    if (t.has("formula")) {
      auto formula = parse_formula(text);
      const auto sound = formula ? check_formula(*formula, c.level, read_) : Result<void>();
      if (!formula)
        t.error_at("formula", formula.error().message);
      else if (!sound)
        t.error_at("formula", sound.error().message);
      else
        c.formula = std::move(*formula);
    }
    read_.computed.push_back(std::move(c));
  }

  void requirement(TomlTable& t) {
    Requirement r{.name = t.string("name")};
    const bool known = std::ranges::find(read_.computed, r.name, &Computed::name) != read_.computed.end();
    if (t.has("name") && !known) t.error_at("name", "\"" + r.name + "\" is no computed number");
    r.clause = t.string_or("clause", "");
    r.rule = t.choice_or("rule", "guarded", {"guarded", "simple"}) == "simple" ? DecisionRule::simple
                                                                               : DecisionRule::guarded;
    r.risk = t.number_or("risk", r.risk, {1e-6, 0.5});
    if (t.has("category")) {
      for (TomlTable& c : t.tables("category")) category(c, r.categories);
    } else {
      r.limits = required_interval(t);
    }
    read_.requirements.push_back(std::move(r));
  }

  void category(TomlTable& t, std::vector<Category>& all) {
    Category c{required_text(t, "name"), required_interval(t)};
    if (!all.empty() && c.range.low < all.back().range.high)
      t.error_at("least", "must not be below the most of the category before");
    all.push_back(std::move(c));
  }

  TomlTable root_;
  Protocol read_;
};

bool is_path(const std::string& name) { return name.ends_with(".toml") || name.find('/') != name.npos; }

Result<std::filesystem::path> protocols_folder() {
  const auto share = config::share_folder();
  if (!share) return tl::unexpected(share.error());
  return *share / "protocols";
}

Result<std::string> path_of(const std::string& name) {
  if (is_path(name)) return name;
  const auto folder = protocols_folder();
  const auto names = shipped_protocols();
  if (!folder || !names) return tl::unexpected(folder ? names.error() : folder.error());
  if (std::ranges::find(*names, name) != names->end()) return (*folder / (name + ".toml")).string();
  return fail("no protocol " + name + config::did_you_mean(name, *names) + "; a file's name ends in .toml");
}

}  // namespace

Result<Protocol> read_protocol(std::string_view text, const std::string& file_name) {
  TomlReader reader(text, file_name);
  if (const auto error = reader.error_so_far()) return tl::unexpected(*error);
  Protocol protocol = ProtocolReader(reader.root()).run();
  if (const auto error = reader.error()) return tl::unexpected(*error);
  protocol.name = std::filesystem::path(file_name).stem().string();
  return protocol;
}

Result<Protocol> load_protocol(const std::string& name_or_path) {
  const auto path = path_of(name_or_path);
  if (!path) return tl::unexpected(path.error());
  const auto text = config::read_file(*path);
  return text ? read_protocol(*text, *path) : tl::unexpected(text.error());
}

Result<std::string> protocol_text(const std::string& name_or_path) {
  const auto path = path_of(name_or_path);
  return path ? config::read_file(*path) : tl::unexpected(path.error());
}

Result<std::vector<std::string>> shipped_protocols() {
  const auto folder = protocols_folder();
  if (!folder) return tl::unexpected(folder.error());
  std::vector<std::string> names;
  std::error_code error;
  for (auto file = std::filesystem::directory_iterator(*folder, error);
       !error && file != std::filesystem::directory_iterator(); file.increment(error))
    if (file->path().extension() == ".toml") names.push_back(file->path().stem().string());
  if (error) return fail(folder->string() + ": " + error.message());
  std::ranges::sort(names);
  return names;
}

}  // namespace strobe::protocol
