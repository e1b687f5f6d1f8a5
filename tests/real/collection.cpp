#include "tests/real/collection.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "common/config/files.hpp"
#include "common/messages/parsed_json.hpp"

namespace strobe::real {

namespace {

using nlohmann::json;

constexpr std::array kPhotographFields{"file",    "ball_diameter_m", "px_per_m",  "balls",  "ghost_path",
                                       "curved",  "bounces",         "camera",    "light",  "ball",
                                       "licence", "source",          "annotator", "second", "why"};
constexpr std::array kSecondFields{"annotator", "balls"};
constexpr std::array kBallFields{"x", "y", "d", "kind", "seen", "why"};

/// A field and where it stands, for messages. Throws Error.
class Field {
 public:
  Field(const json& value, std::string place) : value_(value), place_(std::move(place)) {}

  [[noreturn]] void refuse(const std::string& why) const { throw Error{place_ + ": " + why}; }

  template <std::size_t count>
  void check_object(const std::array<const char*, count>& known) const {
    if (!value_.is_object()) refuse("must be an object");
    for (const auto& item : value_.items())
      if (std::none_of(known.begin(), known.end(), [&](const char* name) { return item.key() == name; }))
        throw Error{fmt::format("{}: has no field \"{}\"", place_, printable(item.key()))};
  }

  bool has(const char* key) const { return value_.contains(key); }

  Field at(const char* key) const {
    const auto found = value_.find(key);
    if (found == value_.end()) refuse(fmt::format("lacks \"{}\"", key));
    return {*found, fmt::format("{}: {}", place_, key)};
  }

  std::vector<Field> items() const {
    if (!value_.is_array()) refuse("must be a list");
    std::vector<Field> all;
    for (std::size_t i = 0; i < value_.size(); ++i)
      all.emplace_back(value_[i], fmt::format("{}[{}]", place_, i));
    return all;
  }

  double number(double lowest, bool included, double highest) const {
    const double value = value_.is_number() ? value_.get<double>() : NAN;
    if (!std::isfinite(value) || value > highest || (included ? value < lowest : value <= lowest))
      refuse(
          fmt::format("must be a number {} {} and at most {}", included ? "from" : "above", lowest, highest));
    return value;
  }

  std::string text() const {
    if (!value_.is_string() || value_.get<std::string>().empty()) refuse("must be a text");
    return value_.get<std::string>();
  }

  bool truth() const {
    if (!value_.is_boolean()) refuse("must be true or false");
    return value_.get<bool>();
  }

  static std::string printable(std::string words) {
    std::replace_if(
        words.begin(), words.end(), [](unsigned char c) { return c < ' ' || c > '~'; }, '?');
    return words.substr(0, 60);
  }

 private:
  const json& value_;
  std::string place_;
};

/// No picture that is read has sides of more pixels; balls may lie partly outside.
constexpr double kMaxPx = 1e6;

Ball ball_of(const Field& field) {
  field.check_object(kBallFields);
  Ball ball;
  ball.x = field.at("x").number(-kMaxPx, true, kMaxPx);
  ball.y = field.at("y").number(-kMaxPx, true, kMaxPx);
  ball.d = field.at("d").number(0.0, false, kMaxPx);
  const std::string kind = field.at("kind").text();
  if (kind == "optional")
    ball.kind = Kind::optional;
  else if (kind == "ghost")
    ball.kind = Kind::ghost;
  else if (kind != "ball")
    field.at("kind").refuse("must be \"ball\", \"optional\" or \"ghost\"");
  if (field.has("seen")) field.at("seen").number(0.0, true, 1.0);
  if (field.has("why")) field.at("why").text();
  return ball;
}

std::vector<Ball> balls_of(const Field& field) {
  std::vector<Ball> balls;
  for (const Field& each : field.items()) balls.push_back(ball_of(each));
  return balls;
}

std::vector<Point> path_of(const Field& field) {
  std::vector<Point> path;
  for (const Field& each : field.items()) {
    const auto corner = each.items();
    if (corner.size() != 2) each.refuse("must be [x, y]");
    path.push_back({corner[0].number(-kMaxPx, true, kMaxPx), corner[1].number(-kMaxPx, true, kMaxPx)});
    if (path.size() > 1 &&
        std::hypot(path.back().x - path[path.size() - 2].x, path.back().y - path[path.size() - 2].y) == 0.0)
      each.refuse("is the corner before it once more");
  }
  if (path.size() < 2) field.refuse("must have two corners or more");
  return path;
}

std::string file_name_of(const Field& field) {
  const std::string name = field.text();
  const std::filesystem::path path(name);
  const bool is_ascii = std::ranges::all_of(name, [](char c) { return c >= ' ' && c <= '~'; });
  if (!is_ascii || path.is_absolute() ||
      std::find(path.begin(), path.end(), "..") != path.end())
    field.refuse("must be the name of a file in this folder");
  return name;
}

Photograph photograph_of(const json& value, const std::string& place) {
  const Field unnamed(value, place);
  if (!value.is_object()) unnamed.refuse("must be an object");
  const std::string file = file_name_of(unnamed.at("file"));
  const Field field(value, fmt::format("{} ({})", place, file));
  field.check_object(kPhotographFields);
  Photograph photograph;
  photograph.file = file;
  photograph.ball_diameter_m = field.at("ball_diameter_m").number(0.0, false, 10.0);
  photograph.px_per_m = field.at("px_per_m").number(0.0, false, kMaxPx);
  photograph.balls = balls_of(field.at("balls"));
  if (field.has("ghost_path")) photograph.ghost_path = path_of(field.at("ghost_path"));
  if (field.has("curved")) photograph.curved = field.at("curved").truth();
  if (field.has("bounces")) photograph.bounces = field.at("bounces").truth();
  for (const char* words : {"camera", "light", "ball", "licence", "source", "annotator", "why"})
    if (field.has(words)) field.at(words).text();
  if (field.has("second")) {
    const Field second = field.at("second");
    second.check_object(kSecondFields);
    if (second.has("annotator")) second.at("annotator").text();
    photograph.second = balls_of(second.at("balls"));
  }
  return photograph;
}

}  // namespace

Result<std::vector<Photograph>> parse_collection(std::string_view text, const std::string& name) {
  const auto entries = messages::parsed_json<json>(text);
  if (entries.is_discarded()) return fail(name + ": is not JSON");
  if (!entries.is_array()) return fail(name + ": must be a list of photographs");
  std::vector<Photograph> photographs;
  std::set<std::string> files;
  try {
    for (std::size_t i = 0; i < entries.size(); ++i) {
      photographs.push_back(photograph_of(entries[i], fmt::format("{}: photograph {}", name, i + 1)));
      if (!files.insert(photographs.back().file).second)
        return fail(
            fmt::format("{}: photograph {} ({}): stands there twice", name, i + 1, photographs.back().file));
    }
  } catch (const Error& error) {
    return fail(error.message);
  }
  return photographs;
}

Result<std::vector<Photograph>> load_collection(const std::filesystem::path& folder) {
  const std::string name = (folder / "truth.json").string();
  const auto text = config::read_file(name);
  if (!text) return fail(text.error().message);
  auto photographs = parse_collection(*text, name);
  if (!photographs) return photographs;
  for (Photograph& photograph : *photographs) {
    photograph.path = folder / photograph.file;
    std::error_code error;
    if (!std::filesystem::is_regular_file(photograph.path, error))
      return fail(fmt::format("{}: {}: no such file", name, photograph.file));
  }
  return photographs;
}

}  // namespace strobe::real
