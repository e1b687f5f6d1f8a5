#include "host/digitize/equator/line_search.hpp"

#include <algorithm>
#include <memory>
#include <numbers>
#include <numeric>
#include <opencv2/core/hal/intrin.hpp>

#include "host/digitize/core/statistics.hpp"

namespace strobe::digitize {
namespace {

constexpr int kMaxCells = 44;        ///< a radius
constexpr double kSlightTilt = 0.3;  ///< 5 degrees of tilt, and what perspective adds off the axis
constexpr double kMaxTilt = 1.2;     ///< beyond, hardly half a radius of the line is seen
constexpr double kClip = 2.5;        ///< sd, largest contribution of one column

/// Narrow lines need finer steps of tilt.
struct Width {
  double half = 0.0;  ///< radii
  int steps = 1;      ///< of tilt, to kSlightTilt
};
constexpr std::array kWidths{Width{0.022, 4}, Width{0.045, 3}, Width{0.09, 2}};

/// The matched filter of one width and tilt, in cells.
struct Pattern {
  double tilt_rad = 0.0;
  int half = 0;             ///< of the line
  int gap = 0;              ///< from its middle to the nearest cell of its sides
  int side = 0;             ///< width of each
  std::vector<int> middle;  ///< [column]

  int reach() const { return gap + side - 1; }
};

struct Patterns {
  double half_width = 0.0;     ///< radii
  std::vector<Pattern> tilts;  ///< from the least
};

/// The search grid for balls of one size.
struct Plan {
  int angles = 0;
  int columns = 0;  ///< along a strip
  int rows = 0;     ///< of a strip, to either side of its middle
  std::vector<Patterns> widths;

  double angle(int k) const { return std::numbers::pi * k / angles; }
  double along(int column) const { return 0.94 * (2.0 * (column + 0.5) / columns - 1.0); }
};

Pattern make_pattern(const Plan& plan, double half_width, double tilt_rad, int per_radius) {
  Pattern pattern;
  pattern.tilt_rad = tilt_rad;
  // Along v' a tilted line is foreshortened alike everywhere.
  if (std::abs(tilt_rad) > kSlightTilt) half_width *= std::cos(tilt_rad);
  pattern.half = std::max(0, static_cast<int>(std::lround(half_width * per_radius - 0.5)));
  pattern.gap = pattern.half + 2;
  pattern.side = std::max(2, pattern.half + 1);
  const double sine = std::sin(tilt_rad);
  for (int column = 0; column < plan.columns; ++column) {
    const double a = plan.along(column);
    pattern.middle.push_back(static_cast<int>(std::lround(sine * std::sqrt(1.0 - a * a) * per_radius)));
  }
  return pattern;
}

Plan make_plan(int per_radius, Effort effort, TiltRange range) {
  Plan plan;
  plan.angles = effort == Effort::fast ? 45 : 60;
  plan.columns = effort == Effort::fast ? 28 : 36;
  const double most = range == TiltRange::all ? kMaxTilt : kSlightTilt;
  for (const Width& width : kWidths) {
    if (width.half * per_radius < 0.6) continue;  // finer than the cells
    Patterns& patterns = plan.widths.emplace_back(Patterns{width.half, {}});
    const int steps = static_cast<int>(std::lround(width.steps * most / kSlightTilt));
    for (int t = -steps; t <= steps; ++t) {
      patterns.tilts.push_back(make_pattern(plan, width.half, most * t / steps, per_radius));
      plan.rows =
          std::max(plan.rows, patterns.tilts.back().reach() + 1 + static_cast<int>(most * per_radius));
    }
  }
  return plan;
}

/// The disc in square cells: intensity relative to the shading, weighted.
class Cells {
 public:
  explicit Cells(BallPixels& pixels)
      : per_radius_(std::clamp(static_cast<int>(pixels.disc().radius_image_px / pixels.stride() / 1.4), 4,
                               kMaxCells)),
        side_(2 * per_radius_ + 1),
        cells_(static_cast<std::size_t>(side_ * side_)) {
    fill(pixels);
  }

  int per_radius() const { return per_radius_; }
  double saturated() const { return saturated_; }
  double outside() const { return outside_; }
  struct Cell {
    float sum = 0.0F, weight = 0.0F;
  };
  /// In the column `i` and the row `j`, the middle one being per_radius().
  const Cell& at(int i, int j) const { return cells_[index(i, j)]; }

 private:
  std::size_t index(int i, int j) const { return static_cast<std::size_t>(j * side_ + i); }
  void fill(BallPixels& pixels);

  int per_radius_;
  int side_;
  std::vector<Cell> cells_;
  double saturated_ = 0.0;
  double outside_ = 0.0;
};

void Cells::fill(BallPixels& pixels) {
  const double radius = pixels.disc().radius_image_px / pixels.stride();
  const auto share = static_cast<float>(per_radius_ * per_radius_ / (radius * radius));  // of a cell
  const float floor2 = pixels.floor() * pixels.floor();
  int inside = 0, full = 0;
  const cv::Range range = pixels.rows(kInner);
  for (int j = range.start; j < range.end; ++j) {
    for (const BallPixels::Pixel& pixel : pixels.row(j, kInner)) {
      ++inside;
      if (pixel.saturated) ++full;
      if (!pixel.usable || pixel.shading <= pixels.floor()) continue;
      // Least squares for residual = shading·x, weighted by the inverse variance.
      const float scale = share / (pixel.variance + floor2);
      const int column = static_cast<int>((pixel.u + 1.0) * per_radius_ + 0.5),
                row = static_cast<int>((pixel.v + 1.0) * per_radius_ + 0.5);
      Cell& cell = cells_[index(column, row)];
      cell.sum += pixel.residual * pixel.shading * scale;
      cell.weight += pixel.shading * pixel.shading * scale;
    }
  }
  const double whole = CV_PI * kInner * kInner * radius * radius;
  saturated_ = full / std::max(1.0, whole);
  outside_ = std::clamp(1.0 - inside / whole, 0.0, 1.0);
}

/// Angles that are worked on at a time, a lane each.
constexpr int kAtOnce = 4;
using Lanes = cv::v_float32x4;

/// Cumulative sums along the columns across a strip, of kAtOnce angles from one on; those beyond the plan's
/// last are searched for nothing.
class Strips {
 public:
  Strips(const Cells& cells, const Plan& plan, int first_angle)
      : half_(plan.rows), rows_(static_cast<std::size_t>(2 * half_ + 2)) {
    sums_ = std::make_unique_for_overwrite<Sums[]>(static_cast<std::size_t>(plan.columns) * rows_);
    std::array<float, kAtOnce> cosine, sine;
    for (int lane = 0; lane < kAtOnce; ++lane) {
      const auto of = static_cast<std::size_t>(lane);
      cosine[of] = static_cast<float>(std::cos(plan.angle(first_angle + lane)));
      sine[of] = static_cast<float>(std::sin(plan.angle(first_angle + lane)));
    }
    const Lanes c = cv::v_load(cosine.data()), s = cv::v_load(sine.data());
    for (int column = 0; column < plan.columns; ++column) fill(cells, plan, c, s, column);
  }

  struct Mean {
    Lanes sum, weight;
  };
  /// Over cells from `low` to `high` across, both included and within the plan's rows.
  Mean over(int column, int low, int high) const {
    const Sums* base = sums_.get() + static_cast<std::size_t>(column) * rows_ + half_;
    const Sums &from = base[low], &to = base[high + 1];
    return {cv::v_load(to.sum.data()) - cv::v_load(from.sum.data()),
            cv::v_load(to.weight.data()) - cv::v_load(from.weight.data())};
  }

 private:
  struct Sums {
    std::array<float, kAtOnce> sum, weight;
  };

  void fill(const Cells& cells, const Plan& plan, const Lanes& c, const Lanes& s, int column) {
    const double a = plan.along(column), step = 1.0 / cells.per_radius();
    const int most = std::min(half_, static_cast<int>(std::sqrt(kInner * kInner - a * a) / step));
    const auto place = [](float at) { return cv::v_setall_f32(at); };
    const float along = static_cast<float>(a * cells.per_radius()),
                middle = static_cast<float>(cells.per_radius()) + 0.5F;
    const Lanes column_at = place(along) * c + place(middle), row_at = place(along) * s + place(middle);
    Sums* at = sums_.get() + static_cast<std::size_t>(column) * rows_;
    *at++ = {};
    Lanes sum = cv::v_setzero_f32(), weight = sum;
    std::array<int, kAtOnce> i, j;
    for (int k = -half_; k <= half_; ++k, ++at) {
      if (std::abs(k) <= most) {
        const Lanes across = place(static_cast<float>(k));
        cv::v_store(i.data(), cv::v_trunc(column_at - across * s));
        cv::v_store(j.data(), cv::v_trunc(row_at + across * c));
        const std::array of{cells.at(i[0], j[0]), cells.at(i[1], j[1]), cells.at(i[2], j[2]),
                            cells.at(i[3], j[3])};
        sum = sum + Lanes(of[0].sum, of[1].sum, of[2].sum, of[3].sum);
        weight = weight + Lanes(of[0].weight, of[1].weight, of[2].weight, of[3].weight);
      }
      cv::v_store(at->sum.data(), sum);
      cv::v_store(at->weight.data(), weight);
    }
  }

  int half_;
  std::size_t rows_;
  std::unique_ptr<Sums[]> sums_;
};

constexpr float kInvisible = -1e9F;

/// How much darker the column is at the line than on both sides.
Lanes darkness(const Strips& strips, const Pattern& pattern, int column, int middle) {
  const Lanes invisible = cv::v_setall_f32(kInvisible);
  const auto inner = strips.over(column, middle - pattern.half, middle + pattern.half);
  // A fully visible cell has weight one.
  const Lanes seen = inner.weight >= cv::v_setall_f32(0.15F * static_cast<float>(2 * pattern.half + 1));
  if (!cv::v_check_any(seen)) return invisible;
  const auto below = strips.over(column, middle - pattern.reach(), middle - pattern.gap);
  const auto above = strips.over(column, middle + pattern.gap, middle + pattern.reach());
  const Lanes least = cv::v_setall_f32(0.15F * static_cast<float>(pattern.side));
  const Lanes has_below = below.weight >= least, has_above = above.weight >= least;
  const Lanes has_both = has_below & has_above;
  // below.sum/below.weight and so on, with one division
  const Lanes both = cv::v_setall_f32(2.0F) * below.weight * above.weight;
  const Lanes sides = below.sum * above.weight + above.sum * below.weight;
  Lanes dark = (sides * inner.weight - inner.sum * both) / (both * inner.weight);
  if (!cv::v_check_all(has_both)) {
    const Lanes sum = cv::v_select(has_below, below.sum, above.sum),
                weight = cv::v_select(has_below, below.weight, above.weight);
    const Lanes by_one = sum / weight - inner.sum / inner.weight;
    dark = cv::v_select(has_both, dark, cv::v_select(has_below | has_above, by_one, invisible));
  }
  return cv::v_select(seen, dark, invisible);
}

/// Darkness of every column of every strip and tilt, for one width.
struct Table {
  int angles = 0;
  int tilts = 0;
  int of_strip = 0;         ///< columns
  std::vector<float> dark;  ///< [angle / kAtOnce][tilt][column][angle % kAtOnce]

  std::span<const float> columns(int first_angle, int tilt_index) const {
    const auto size = static_cast<std::size_t>(of_strip * kAtOnce);
    return std::span(dark).subspan(
        static_cast<std::size_t>(first_angle / kAtOnce * tilts + tilt_index) * size, size);
  }
};

Table fill_table(const std::vector<Strips>& strips, const Plan& plan, const Patterns& patterns) {
  Table table{plan.angles, static_cast<int>(patterns.tilts.size()), plan.columns, {}};
  table.dark.resize(strips.size() * patterns.tilts.size() * static_cast<std::size_t>(plan.columns) * kAtOnce);
  float* dark = table.dark.data();
  for (const Strips& of_angles : strips) {
    for (const Pattern& pattern : patterns.tilts) {
      const int* middle = pattern.middle.data();
      for (int column = 0; column < plan.columns; ++column, dark += kAtOnce)
        cv::v_store(dark, darkness(of_angles, pattern, column, *middle++));
    }
  }
  return table;
}

/// Robust sd of the columns' darkness anywhere on the ball. Returns 0 for too few columns.
double spread(const Table& table) {
  std::vector<float> values;
  for (int first = 0; first < table.angles; first += kAtOnce) {
    const auto columns = table.columns(first, table.tilts / 2);
    const int lanes = std::min(kAtOnce, table.angles - first);
    for (std::size_t k = 0; k < columns.size(); ++k)
      if (static_cast<int>(k % kAtOnce) < lanes && columns[k] != kInvisible)
        values.push_back(std::abs(columns[k]));
  }
  if (values.size() < 50) return 0.0;
  return kSdOverMad * upper_median(std::move(values));
}

struct Tally {
  double score = 0.0;
  double contrast = 0.0;
  int visible = 0;  ///< columns
};

/// Of kAtOnce angles.
std::array<Tally, kAtOnce> tally(std::span<const float> columns, double sd) {
  const Lanes limit = cv::v_setall_f32(static_cast<float>(kClip * sd)), one = cv::v_setall_f32(1.0F),
              invisible = cv::v_setall_f32(kInvisible), none = cv::v_setzero_f32();
  Lanes clipped = none, sum = none, visible = none;
  for (std::size_t k = 0; k < columns.size(); k += kAtOnce) {
    const Lanes dark = cv::v_load(&columns[k]), seen = dark != invisible;
    visible += one & seen;
    clipped += cv::v_max(none - limit, cv::v_min(dark, limit)) & seen;
    sum += dark & seen;
  }
  std::array<float, kAtOnce> clipped_of, sum_of, visible_of;
  cv::v_store(clipped_of.data(), clipped);
  cv::v_store(sum_of.data(), sum);
  cv::v_store(visible_of.data(), visible);
  std::array<Tally, kAtOnce> result;
  for (std::size_t lane = 0; lane < kAtOnce; ++lane) {
    if (!(visible_of[lane] > 0.0F)) continue;
    const auto count = static_cast<double>(visible_of[lane]);
    result[lane] = {static_cast<double>(clipped_of[lane]) / sd / std::sqrt(count),
                    static_cast<double>(sum_of[lane]) / count, static_cast<int>(count)};
  }
  return result;
}

/// The best line at each angle.
class BestLines {
 public:
  explicit BestLines(const Plan& plan)
      : plan_(plan), peaks_(static_cast<std::size_t>(plan.angles)), rank_(peaks_.size(), kNoRank) {}

  /// Of one width. Returns the largest number of visible columns at any angle.
  int update(const Table& table, const Patterns& patterns) {
    int visible = 0;
    const double sd = spread(table);
    if (!(sd > 0.0)) return visible;
    for (int first = 0; first < plan_.angles; first += kAtOnce) {
      for (int t = 0; t < table.tilts; ++t) {
        const auto found = tally(table.columns(first, t), sd);
        for (int k = first; k < std::min(first + kAtOnce, plan_.angles); ++k) {
          const Tally& one = found[static_cast<std::size_t>(k - first)];
          visible = std::max(visible, one.visible);
          update(k, one, sd, patterns.tilts[static_cast<std::size_t>(t)].tilt_rad, patterns.half_width);
        }
      }
    }
    return visible;
  }

  /// Best first, apart from each other.
  std::vector<LinePeak> peaks() const {
    constexpr double kMinApart = 8.0 * std::numbers::pi / 180.0;
    constexpr std::size_t kMaxPlaces = 4;
    std::vector<std::size_t> order(peaks_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return rank_[a] > rank_[b]; });
    std::vector<LinePeak> result;
    for (const std::size_t k : order) {
      if (rank_[k] <= kNoRank || result.size() >= kMaxPlaces) break;
      const bool near = std::ranges::any_of(
          result, [&](const LinePeak& peak) { return angle_between(peak.line, peaks_[k].line) < kMinApart; });
      if (!near) result.push_back(peaks_[k]);
    }
    return result;
  }

 private:
  static constexpr double kNoRank = -1e30;

  void update(int angle, const Tally& found, double sd, double tilt_rad, double half_width) {
    if (found.visible < plan_.columns / 4) return;
    // The score is clipped for strong lines: among similar scores the darker line is preferred.
    const double rank = found.score + 0.3 * found.contrast / sd;
    const auto at = static_cast<std::size_t>(angle);
    if (rank <= rank_[at]) return;
    rank_[at] = rank;
    LinePeak& peak = peaks_[at];
    peak.line.angle_rad = plan_.angle(angle);
    peak.line.tilt_rad = tilt_rad;
    peak.line.contrast = found.contrast;
    peak.line.shape.half_width = half_width;
    peak.score = found.score;
  }

  const Plan& plan_;
  std::vector<LinePeak> peaks_;
  std::vector<double> rank_;
};

}  // namespace

LineSearch search_line(BallPixels& pixels, Effort effort, TiltRange range) {
  LineSearch search;
  const Cells cells(pixels);
  search.saturated = cells.saturated();
  search.outside = cells.outside();
  const Plan plan = make_plan(cells.per_radius(), effort, range);
  std::vector<Strips> strips;
  for (int k = 0; k < plan.angles; k += kAtOnce) strips.emplace_back(cells, plan, k);
  BestLines best(plan);
  int visible = 0;
  for (const Patterns& patterns : plan.widths)
    visible = std::max(visible, best.update(fill_table(strips, plan, patterns), patterns));
  search.visible = static_cast<double>(visible) / plan.columns;
  search.peaks = best.peaks();
  return search;
}

}  // namespace strobe::digitize
