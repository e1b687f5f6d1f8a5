#include "common/data/published_bounces.hpp"

#include <algorithm>
#include <array>

#include "common/config/files.hpp"
#include "common/data/csv.hpp"

namespace strobe::published {

namespace {

constexpr std::array<std::string_view, 16> kBounceColumns{
    "row",       "ball",         "surface",        "incline_deg",       "vx_td_mps", "vx_td_sd_mps",
    "vy_td_mps", "vy_td_sd_mps", "omega_td_radps", "omega_td_sd_radps", "vx_lo_mps", "vx_lo_sd_mps",
    "vy_lo_mps", "vy_lo_sd_mps", "omega_lo_radps", "omega_lo_sd_radps"};
constexpr std::array<std::string_view, 8> kBallColumns{"ball",  "build",    "diameter_m",    "mass_kg",
                                                       "alpha", "alpha_sd", "poisson_ratio", "source"};
constexpr std::array<std::string_view, 3> kSetColumns{"set", "publication", "read_from"};
constexpr std::array<std::string_view, 8> kFrictionColumns{
    "set", "surface", "ground", "row", "mu", "elsewhere_mu", "elsewhere_mu_sd", "reason"};
constexpr std::array<std::string_view, 4> kGrounds{"hard", "pad", "strings", "turf"};

/// The cells of one row, each with its column's name for errors. The first thing wrong stays.
class Row {
 public:
  Row(const data::CsvRow& row, std::string_view source, std::span<const std::string_view> columns)
      : row_(row), source_(source), columns_(columns) {}

  std::string_view cell(std::size_t i) const { return row_.cells[i]; }

  std::string text(std::size_t i) {
    if (cell(i).empty()) wrong(i, "is missing");
    return std::string(cell(i));
  }

  double number(std::size_t i) {
    const auto value = data::parse_number(cell(i), source_, row_.line, columns_[i]);
    if (value) return *value;
    if (!error_) error_ = value.error();
    return 0.0;
  }

  /// A value with its sd in the next column.
  Measured measured(std::size_t i) {
    const Measured out{number(i), number(i + 1)};
    if (out.sd < 0.0) wrong(i + 1, "must not be negative");
    return out;
  }

  std::optional<Measured> optional_measured(std::size_t i) {
    if (cell(i).empty() && cell(i + 1).empty()) return std::nullopt;
    return measured(i);
  }

  void wrong(std::size_t i, std::string_view what) {
    if (!error_) error_ = data::csv_error(source_, row_.line, columns_[i], what).value();
  }

  const std::optional<Error>& error() const { return error_; }

 private:
  const data::CsvRow& row_;
  std::string_view source_;
  std::span<const std::string_view> columns_;
  std::optional<Error> error_;
};

template <typename Named>
const Named* find(const std::vector<Named>& all, std::string_view name) {
  const auto found = std::ranges::find(all, name, &Named::name);
  return found == all.end() ? nullptr : &*found;
}

Bounce bounce_of(Row& row) {
  Bounce b{.name = row.text(0), .ball = row.text(1), .surface = row.text(2)};
  if (!row.cell(3).empty()) b.incline_deg = row.number(3);
  if (b.incline_deg.value_or(0.0) < 0.0 || b.incline_deg.value_or(0.0) > 90.0)
    row.wrong(3, "must be from 0 to 90");
  b.vx_td_mps = row.measured(4);
  b.vy_td_mps = row.measured(6);
  if (!(b.vy_td_mps.value < 0.0)) row.wrong(6, "must be negative");
  b.omega_td_radps = row.measured(8);
  b.vx_lo_mps = row.optional_measured(10);
  b.vy_lo_mps = row.optional_measured(12);
  if (b.vy_lo_mps && !(b.vy_lo_mps->value > 0.0 && b.vy_lo_mps->value <= -b.vy_td_mps.value))
    row.wrong(12, "must be positive and not above that of touchdown");
  b.omega_lo_radps = row.optional_measured(14);
  if (!b.vx_lo_mps && !b.omega_lo_radps) row.wrong(14, "is missing, and so is vx_lo_mps");
  return b;
}

Ball ball_of(Row& row) {
  Ball ball{.name = row.text(0)};
  if (row.cell(1) != "shell" && row.cell(1) != "solid") row.wrong(1, "must be shell or solid");
  ball.build = row.cell(1) == "solid" ? Build::solid : Build::shell;
  ball.diameter_m = row.number(2);
  if (!(ball.diameter_m > 0.0)) row.wrong(2, "must be positive");
  ball.mass_kg = row.number(3);
  if (!(ball.mass_kg > 0.0)) row.wrong(3, "must be positive");
  ball.alpha = row.measured(4);
  if (!(ball.alpha.value > 0.0 && ball.alpha.value <= 2.0 / 3.0)) row.wrong(4, "must be in (0, 2/3]");
  if (ball.build == Build::solid) {
    ball.poisson_ratio = row.number(6);
    if (!(*ball.poisson_ratio >= 0.0 && *ball.poisson_ratio <= 0.5)) row.wrong(6, "must be from 0 to 0.5");
  } else if (!row.cell(6).empty()) {
    row.wrong(6, "is a solid ball's");
  }
  ball.source = row.text(7);
  return ball;
}

Friction friction_of(Row& row, const Set& set) {
  Friction f{.surface = row.text(1), .row = std::string(row.cell(3)), .reason = row.text(7)};
  const bool known =
      std::ranges::any_of(set.bounces, [&f](const Bounce& b) { return b.surface == f.surface; });
  if (!known) row.wrong(1, "'" + f.surface + "' is no surface of " + set.name);
  if (set.friction(f.surface) != nullptr) row.wrong(1, "'" + f.surface + "' is given twice");
  const auto ground = std::ranges::find(kGrounds, row.cell(2));
  if (ground == kGrounds.end()) row.wrong(2, "must be hard, pad, strings or turf");
  f.ground = static_cast<Ground>(ground - kGrounds.begin());
  if (f.row.empty() == row.cell(4).empty()) row.wrong(4, "must be given where row is not, and only there");
  if (f.row.empty()) {
    f.mu = row.number(4);
    if (f.mu < 0.0) row.wrong(4, "must not be negative");
  } else {
    const Bounce* bounce = set.bounce(f.row);
    if (bounce == nullptr || !bounce->impulse_ratio())
      row.wrong(3, "'" + f.row + "' is no row of " + set.name + " with velocities at lift-off");
  }
  f.elsewhere = row.optional_measured(5);
  return f;
}

/// Each row by `convert`; names may not repeat.
template <typename Convert>
auto parse_named(std::string_view text, std::string_view source, std::span<const std::string_view> columns,
                 Convert convert) -> Result<std::vector<decltype(convert(std::declval<Row&>()))>> {
  const auto rows = data::parse_csv(text, source, columns);
  if (!rows) return tl::unexpected(rows.error());
  std::vector<decltype(convert(std::declval<Row&>()))> all;
  for (const data::CsvRow& cells : *rows) {
    Row row(cells, source, columns);
    auto one = convert(row);
    if (find(all, one.name) != nullptr) row.wrong(0, "'" + one.name + "' is given twice");
    if (row.error()) return tl::unexpected(*row.error());
    all.push_back(std::move(one));
  }
  if (all.empty()) return data::csv_error(source, 1, "", "has no rows");
  return all;
}

Result<void> check_surfaces(std::span<const Set> sets, std::string_view source) {
  for (const Set& set : sets)
    for (const Bounce& b : set.bounces)
      if (set.friction(b.surface) == nullptr)
        return fail(std::string(source) + ": says nothing of " + b.surface + " of " + set.name);
  return {};
}

Result<void> load_set(const std::filesystem::path& folder, const std::vector<Ball>& balls, Set& set) {
  const std::filesystem::path path = folder / (set.name + ".csv");
  const auto text = config::read_file(path.string());
  if (!text) return tl::unexpected(text.error());
  auto bounces = parse_bounces(*text, path.string());
  if (!bounces) return tl::unexpected(bounces.error());
  for (const Bounce& b : *bounces)
    if (find(balls, b.ball) == nullptr)
      return fail(path.string() + ": " + b.name + ": balls.csv has no ball " + b.ball);
  set.bounces = *std::move(bounces);
  return {};
}

}  // namespace

std::optional<double> Bounce::restitution() const {
  if (!vy_lo_mps) return std::nullopt;
  return -vy_lo_mps->value / vy_td_mps.value;
}

std::optional<double> Bounce::impulse_ratio() const {
  if (!vx_lo_mps || !vy_lo_mps) return std::nullopt;
  return (vx_td_mps.value - vx_lo_mps->value) / (vy_lo_mps->value - vy_td_mps.value);
}

const Bounce* Set::bounce(std::string_view row) const { return find(bounces, row); }

const Friction* Set::friction(std::string_view surface) const {
  const auto found = std::ranges::find(frictions, surface, &Friction::surface);
  return found == frictions.end() ? nullptr : &*found;
}

const Ball* Bounces::ball(std::string_view name) const { return find(balls, name); }
const Set* Bounces::set(std::string_view name) const { return find(sets, name); }

Result<std::vector<Bounce>> parse_bounces(std::string_view text, std::string_view source) {
  return parse_named(text, source, kBounceColumns, bounce_of);
}

Result<std::vector<Ball>> parse_balls(std::string_view text, std::string_view source) {
  return parse_named(text, source, kBallColumns, ball_of);
}

Result<void> parse_frictions(std::string_view text, std::string_view source, std::span<Set> sets) {
  const auto rows = data::parse_csv(text, source, kFrictionColumns);
  if (!rows) return tl::unexpected(rows.error());
  for (const data::CsvRow& cells : *rows) {
    Row row(cells, source, kFrictionColumns);
    const auto set = std::ranges::find(sets, cells.cells[0], &Set::name);
    if (set == sets.end())
      return data::csv_error(source, cells.line, kFrictionColumns[0], "is no set of sets.csv");
    Friction friction = friction_of(row, *set);
    if (row.error()) return tl::unexpected(*row.error());
    set->frictions.push_back(std::move(friction));
  }
  return check_surfaces(sets, source);
}

Result<Bounces> load_bounces(const std::filesystem::path& folder) {
  Bounces all;
  const std::filesystem::path balls = folder / "balls.csv", sets = folder / "sets.csv",
                              friction = folder / "friction.csv";
  for (const auto& path : {balls, sets, friction}) {
    const auto text = config::read_file(path.string());
    if (!text) return tl::unexpected(text.error());
    if (path == balls) {
      auto parsed = parse_balls(*text, path.string());
      if (!parsed) return tl::unexpected(parsed.error());
      all.balls = *std::move(parsed);
    } else if (path == sets) {
      auto parsed = parse_named(*text, path.string(), kSetColumns, [](Row& row) {
        return Set{.name = row.text(0), .publication = row.text(1), .read_from = row.text(2)};
      });
      if (!parsed) return tl::unexpected(parsed.error());
      all.sets = *std::move(parsed);
      for (Set& set : all.sets)
        if (const auto loaded = load_set(folder, all.balls, set); !loaded)
          return tl::unexpected(loaded.error());
    } else if (const auto parsed = parse_frictions(*text, path.string(), all.sets); !parsed) {
      return tl::unexpected(parsed.error());
    }
  }
  return all;
}

}  // namespace strobe::published
