#include "common/data/ball_kind.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <system_error>

#include "common/config/files.hpp"
#include "common/config/toml_reader.hpp"

namespace strobe::balls {
namespace {

namespace fs = std::filesystem;
using config::Range;
using config::TomlTable;

constexpr std::array<std::string_view, 8> kMarkings{"line", "seam",   "dimples", "stitches",
                                                    "dots", "panels", "holes",   "plain"};

Sourced read_sourced(TomlTable table, Range values) {
  Sourced read;
  read.value = table.number("value", values);
  read.sd = table.number("sd", {0.0, values.most});
  read.source = table.string("source");
  return read;
}

flight::AirLaw read_air_law(TomlTable& table) {
  flight::AirLaw law;
  for (const flight::AirLawField& field : flight::kAirLawFields)
    law.*field.member = table.number(field.name, {field.least, field.most});
  if (law.most_mps < law.least_mps) table.error_at("most_mps", "must not be below least_mps");
  return law;
}

std::optional<Elasticity> read_elasticity(TomlTable table) {
  if (!table.present()) return std::nullopt;
  Elasticity read;
  read.per_K = table.number("per_K", {-0.1, 0.1});
  read.per_K_sd = table.number("per_K_sd", {0.0, 0.1});
  read.reference_degC = table.number("reference_degC", {-50.0, 100.0});
  read.source = table.string("source");
  return read;
}

ContactRange read_contact_range(TomlTable table) {
  ContactRange read;
  read.least_normal_mps = table.number("least_normal_mps", {0.0, 200.0});
  read.most_normal_mps = table.number("most_normal_mps", {0.0, 200.0});
  read.dwell_s = table.number("dwell_s", {1e-4, 0.05});
  read.e = table.number("e", {0.05, 0.99});
  read.mu = table.number("mu", {0.0, 2.0});
  read.source = table.string("source");
  if (read.most_normal_mps < read.least_normal_mps)
    table.error_at("most_normal_mps", "must not be below least_normal_mps");
  return read;
}

/// For a person.
std::string rounded(double mps) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g", mps);
  return text.data();
}

/// The file's name without folder and ending.
std::string kind_of_file(const std::string& file_name) { return fs::path(file_name).stem().string(); }

bool is_ball_path(const std::string& name) {
  return name.find('/') != std::string::npos || name.ends_with(".toml");
}

Result<fs::path> balls_folder() {
  const auto share = config::share_folder();
  if (!share) return tl::unexpected(share.error());
  return *share / "balls";
}

}  // namespace

std::string_view name(Marking marking) { return kMarkings[static_cast<std::size_t>(marking)]; }

std::vector<std::string> beyond_ranges(const Kind& kind, std::optional<double> speed_mps,
                                       std::optional<double> normal_mps) {
  std::vector<std::string> told;
  const auto tell = [&](const std::optional<double>& given, double least, double most, const char* what) {
    if (!given || (*given >= least && *given <= most)) return;
    told.push_back(kind.name + ": " + what + " is told for " + rounded(least) + " to " + rounded(most) +
                   " m/s, not for " + rounded(*given) + " m/s");
  };
  tell(speed_mps, kind.air.least_mps, kind.air.most_mps, "drag and lift");
  tell(normal_mps, kind.contact.least_normal_mps, kind.contact.most_normal_mps,
       "the bounce, normal to the surface,");
  return told;
}

Result<Kind> read_ball_kind(std::string_view text, const std::string& file_name) {
  config::TomlReader reader(text, file_name);
  TomlTable root = reader.root();
  Kind kind;
  kind.name = kind_of_file(file_name);
  kind.title = root.string("title");
  const std::string marking = root.choice_or("marking", "plain", {kMarkings.begin(), kMarkings.end()});
  if (!root.has("marking")) root.error_at("marking", "is missing");
  kind.marking = static_cast<Marking>(std::ranges::find(kMarkings, marking) - kMarkings.begin());
  kind.diameter_m = read_sourced(root.table("diameter_m"), {0.01, 1.0});
  kind.mass_kg = read_sourced(root.table("mass_kg"), {0.001, 10.0});
  kind.alpha = read_sourced(root.table("alpha"), {0.01, ball::kThinShellAlpha});
  TomlTable air = root.table("air");
  kind.air = read_air_law(air);
  kind.air_source = air.string("source");
  kind.elasticity = read_elasticity(root.table("elasticity"));
  kind.contact = read_contact_range(root.table("contact"));
  for (TomlTable& remark : root.tables("remark")) kind.remarks.push_back(remark.string("text"));
  if (const auto bad = reader.error()) return fail(bad->message);
  return kind;
}

Result<std::string> ball_kind_path(const std::string& name_or_path) {
  if (is_ball_path(name_or_path)) return name_or_path;
  const auto folder = balls_folder();
  if (!folder) return tl::unexpected(folder.error());
  const fs::path path = *folder / (name_or_path + ".toml");
  std::error_code error;
  if (fs::exists(path, error)) return path.string();
  const auto known = shipped_ball_kinds();
  if (!known) return tl::unexpected(known.error());
  std::string list;
  for (const std::string& each : *known) list += (list.empty() ? "" : ", ") + each;
  return fail("no ball \"" + name_or_path + "\": a path that ends in .toml, or one of " + list);
}

Result<Kind> load_ball_kind(const std::string& name_or_path) {
  const auto path = ball_kind_path(name_or_path);
  if (!path) return tl::unexpected(path.error());
  const auto text = config::read_file(*path);
  if (!text) return tl::unexpected(text.error());
  return read_ball_kind(*text, *path);
}

Result<std::vector<std::string>> shipped_ball_kinds() {
  const auto folder = balls_folder();
  if (!folder) return tl::unexpected(folder.error());
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(*folder, error))
    if (entry.path().extension() == ".toml") names.push_back(entry.path().stem().string());
  if (error) return fail(folder->string() + ": " + error.message());
  std::ranges::sort(names);
  return names;
}

}  // namespace strobe::balls
