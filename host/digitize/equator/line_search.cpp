#include "host/digitize/equator/line_search.hpp"

#include <algorithm>
#include <numbers>
#include <numeric>

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
        sum_(static_cast<std::size_t>(side_ * side_)),
        weight_(sum_.size()) {
    fill(pixels);
  }

  int per_radius() const { return per_radius_; }
  double saturated() const { return saturated_; }
  double outside() const { return outside_; }
  /// Index of the cell at a point inside the disc.
  std::size_t index(double u, double v) const {
    const int i = static_cast<int>(u * per_radius_ + per_radius_ + 0.5);
    const int j = static_cast<int>(v * per_radius_ + per_radius_ + 0.5);
    return static_cast<std::size_t>(j * side_ + i);
  }
  float sum(std::size_t index) const { return sum_[index]; }
  float weight(std::size_t index) const { return weight_[index]; }

 private:
  void fill(BallPixels& pixels);

  int per_radius_;
  int side_;
  std::vector<float> sum_;
  std::vector<float> weight_;
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
      const std::size_t at = index(pixel.u, pixel.v);
      sum_[at] += pixel.residual * pixel.shading * scale;
      weight_[at] += pixel.shading * pixel.shading * scale;
    }
  }
  const double whole = CV_PI * kInner * kInner * radius * radius;
  saturated_ = full / std::max(1.0, whole);
  outside_ = std::clamp(1.0 - inside / whole, 0.0, 1.0);
}

/// Cumulative sums along the columns across a strip of one angle.
class Strip {
 public:
  Strip(const Cells& cells, const Plan& plan, double angle)
      : half_(plan.rows), rows_(static_cast<std::size_t>(2 * half_ + 2)) {
    sums_.resize(static_cast<std::size_t>(plan.columns) * rows_);
    const double c = std::cos(angle), s = std::sin(angle), step = 1.0 / cells.per_radius();
    for (int column = 0; column < plan.columns; ++column) {
      const double a = plan.along(column);
      const int most = std::min(half_, static_cast<int>(std::sqrt(kInner * kInner - a * a) / step));
      Mean* at = sums_.data() + static_cast<std::size_t>(column) * rows_;
      Mean so_far;
      for (int k = -half_; k <= half_; ++k) {
        if (std::abs(k) <= most) {
          const std::size_t cell = cells.index(c * a - s * step * k, s * a + c * step * k);
          so_far.sum += cells.sum(cell);
          so_far.weight += cells.weight(cell);
        }
        *++at = so_far;
      }
    }
  }

  struct Mean {
    float sum = 0.0F;
    float weight = 0.0F;
  };
  /// Over cells from `low` to `high` across, both included and within the plan's rows.
  Mean over(int column, int low, int high) const {
    const Mean* base = sums_.data() + static_cast<std::size_t>(column) * rows_ + half_;
    const Mean &from = base[low], &to = base[high + 1];
    return {to.sum - from.sum, to.weight - from.weight};
  }

 private:
  int half_;
  std::size_t rows_;
  std::vector<Mean> sums_;
};

constexpr float kInvisible = -1e9F;

/// How much darker the column is at the line than on both sides.
float darkness(const Strip& strip, const Pattern& pattern, int column, int middle) {
  const auto inner = strip.over(column, middle - pattern.half, middle + pattern.half);
  // A fully visible cell has weight one.
  if (inner.weight < 0.15F * static_cast<float>(2 * pattern.half + 1)) return kInvisible;
  const auto below = strip.over(column, middle - pattern.reach(), middle - pattern.gap);
  const auto above = strip.over(column, middle + pattern.gap, middle + pattern.reach());
  const float least = 0.15F * static_cast<float>(pattern.side);
  if (below.weight >= least && above.weight >= least) {
    // below.sum/below.weight and so on, with one division
    const float both = 2.0F * below.weight * above.weight;
    const float side = below.sum * above.weight + above.sum * below.weight;
    return (side * inner.weight - inner.sum * both) / (both * inner.weight);
  }
  if (below.weight < least && above.weight < least) return kInvisible;
  const auto& side = below.weight >= least ? below : above;
  return side.sum / side.weight - inner.sum / inner.weight;
}

/// Darkness of every column of every strip and tilt, for one width.
struct Table {
  int angles = 0;
  int tilts = 0;
  int of_strip = 0;         ///< columns
  std::vector<float> dark;  ///< [angle][tilt][column]

  std::span<const float> columns(int angle, int tilt_index) const {
    return std::span(dark).subspan(static_cast<std::size_t>((angle * tilts + tilt_index) * of_strip),
                                   static_cast<std::size_t>(of_strip));
  }
};

Table fill_table(const std::vector<Strip>& strips, const Plan& plan, const Patterns& patterns) {
  Table table{plan.angles, static_cast<int>(patterns.tilts.size()), plan.columns, {}};
  table.dark.resize(strips.size() * patterns.tilts.size() * static_cast<std::size_t>(plan.columns));
  float* dark = table.dark.data();
  for (const Strip& strip : strips) {
    for (const Pattern& pattern : patterns.tilts) {
      const int* middle = pattern.middle.data();
      for (int column = 0; column < plan.columns; ++column)
        *dark++ = darkness(strip, pattern, column, *middle++);
    }
  }
  return table;
}

/// Robust sd of the columns' darkness anywhere on the ball. Returns 0 for too few columns.
double spread(const Table& table) {
  std::vector<float> values;
  for (int angle = 0; angle < table.angles; ++angle)
    for (const float dark : table.columns(angle, table.tilts / 2))
      if (dark != kInvisible) values.push_back(std::abs(dark));
  if (values.size() < 50) return 0.0;
  return kSdOverMad * upper_median(std::move(values));
}

struct Tally {
  double score = 0.0;
  double contrast = 0.0;
  int visible = 0;  ///< columns
};

Tally tally(std::span<const float> columns, double sd) {
  Tally result;
  const auto limit = static_cast<float>(kClip * sd);
  float clipped = 0.0F, sum = 0.0F;
  for (const float dark : columns) {
    if (dark == kInvisible) continue;
    ++result.visible;
    clipped += std::clamp(dark, -limit, limit);
    sum += dark;
  }
  if (result.visible == 0) return result;
  result.score = clipped / sd / std::sqrt(result.visible * 1.0);
  result.contrast = static_cast<double>(sum) / result.visible;
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
    for (int k = 0; k < plan_.angles; ++k) {
      for (int t = 0; t < table.tilts; ++t) {
        const Tally found = tally(table.columns(k, t), sd);
        visible = std::max(visible, found.visible);
        if (found.visible < plan_.columns / 4) continue;
        // The score is clipped for strong lines: among similar scores the darker line is preferred.
        const double rank = found.score + 0.3 * found.contrast / sd;
        const auto at = static_cast<std::size_t>(k);
        if (rank <= rank_[at]) continue;
        rank_[at] = rank;
        LinePeak& peak = peaks_[at];
        peak.line.angle_rad = plan_.angle(k);
        peak.line.tilt_rad = patterns.tilts[static_cast<std::size_t>(t)].tilt_rad;
        peak.line.contrast = found.contrast;
        peak.line.shape.half_width = patterns.half_width;
        peak.score = found.score;
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
  std::vector<Strip> strips;
  for (int k = 0; k < plan.angles; ++k) strips.emplace_back(cells, plan, plan.angle(k));
  BestLines best(plan);
  int visible = 0;
  for (const Patterns& patterns : plan.widths)
    visible = std::max(visible, best.update(fill_table(strips, plan, patterns), patterns));
  search.visible = static_cast<double>(visible) / plan.columns;
  search.peaks = best.peaks();
  return search;
}

}  // namespace strobe::digitize
