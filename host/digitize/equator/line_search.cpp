#include "host/digitize/equator/line_search.hpp"

#include <algorithm>
#include <numbers>

namespace strobe::digitize {
namespace {

constexpr double kSearchInner = 0.95;
constexpr int kMaxCells = 44;      ///< a radius
constexpr double kTiltMost = 0.3;  ///< 5 degrees of tilt, and what perspective adds off the axis
constexpr double kClip = 2.5;      ///< sd that one column may count

/// A narrow line needs its tilt known the better.
struct Width {
  double half = 0.0;  ///< radii
  int tilts = 1;
};
constexpr std::array kWidths{Width{0.022, 9}, Width{0.045, 7}, Width{0.09, 5}};

double tilt(int index, int tilts) { return kTiltMost * (2.0 * index / (tilts - 1) - 1.0); }

/// How a strip is searched for lines of one width, in cells.
struct Pattern {
  double half_width = 0.0;  ///< radii
  int tilts = 1;
  int half = 0;             ///< of the line
  int gap = 0;              ///< from its middle to the nearest cell of its sides
  int side = 0;             ///< width of each
  std::vector<int> middle;  ///< [tilt][column]

  int reach() const { return gap + side - 1; }
};

/// What is common to all balls of a size.
struct Plan {
  int angles = 0;
  int columns = 0;  ///< along a strip
  int rows = 0;     ///< of a strip, to either side of its middle
  std::vector<Pattern> patterns;

  double along(int column) const { return 0.94 * (2.0 * (column + 0.5) / columns - 1.0); }
};

Pattern make_pattern(const Plan& plan, const Width& width, int per_radius) {
  Pattern pattern;
  pattern.half_width = width.half;
  pattern.tilts = width.tilts;
  pattern.half = std::max(0, static_cast<int>(std::lround(width.half * per_radius - 0.5)));
  pattern.gap = pattern.half + 2;
  pattern.side = std::max(2, pattern.half + 1);
  for (int t = 0; t < width.tilts; ++t) {
    const double sine = std::sin(tilt(t, width.tilts));
    for (int column = 0; column < plan.columns; ++column) {
      const double a = plan.along(column);
      pattern.middle.push_back(static_cast<int>(std::lround(sine * std::sqrt(1.0 - a * a) * per_radius)));
    }
  }
  return pattern;
}

Plan make_plan(int per_radius, Effort effort) {
  Plan plan;
  plan.angles = effort == Effort::fast ? 45 : 60;
  plan.columns = effort == Effort::fast ? 28 : 36;
  for (const Width& width : kWidths) {
    if (width.half * per_radius < 0.6) continue;  // finer than the cells
    plan.patterns.push_back(make_pattern(plan, width, per_radius));
    plan.rows =
        std::max(plan.rows, plan.patterns.back().reach() + 1 + static_cast<int>(kTiltMost * per_radius));
  }
  return plan;
}

/// The disc in square cells: brightness relative to the ball's own, weighted.
class Cells {
 public:
  explicit Cells(BallPixels& rows)
      : per_radius_(
            std::clamp(static_cast<int>(rows.disc().radius_image_px / rows.stride() / 1.4), 4, kMaxCells)),
        side_(2 * per_radius_ + 1),
        sum_(static_cast<std::size_t>(side_ * side_)),
        weight_(sum_.size()) {
    fill(rows);
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
  void fill(BallPixels& rows);

  int per_radius_;
  int side_;
  std::vector<float> sum_;
  std::vector<float> weight_;
  double saturated_ = 0.0;
  double outside_ = 0.0;
};

void Cells::fill(BallPixels& rows) {
  const double radius = rows.disc().radius_image_px / rows.stride();
  const auto share = static_cast<float>(per_radius_ * per_radius_ / (radius * radius));  // of a cell
  const float floor2 = rows.floor() * rows.floor();
  int inside = 0, full = 0;
  const cv::Range range = rows.rows(kSearchInner);
  for (int j = range.start; j < range.end; ++j) {
    for (const BallPixels::Block& block : rows.row(j, kSearchInner)) {
      ++inside;
      if (block.full) ++full;
      if (!block.use || block.own <= rows.floor()) continue;
      // Least squares for left = own * x with noise in proportion to sqrt(noise): sums of own*left and own².
      const float scale = share / (block.noise + floor2);
      const std::size_t at = index(block.u, block.v);
      sum_[at] += block.left * block.own * scale;
      weight_[at] += block.own * block.own * scale;
    }
  }
  const double whole = CV_PI * kSearchInner * kSearchInner * radius * radius;
  saturated_ = full / std::max(1.0, whole);
  outside_ = std::clamp(1.0 - inside / whole, 0.0, 1.0);
}

/// Sums along columns across a strip, so that any stretch costs two look-ups.
class Strip {
 public:
  Strip(const Cells& cells, const Plan& plan, double angle)
      : half_(plan.rows), rows_(static_cast<std::size_t>(2 * half_ + 2)) {
    sums_.resize(static_cast<std::size_t>(plan.columns) * rows_);
    const double c = std::cos(angle), s = std::sin(angle), step = 1.0 / cells.per_radius();
    for (int column = 0; column < plan.columns; ++column) {
      const double a = plan.along(column);
      const int most =
          std::min(half_, static_cast<int>(std::sqrt(kSearchInner * kSearchInner - a * a) / step));
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

constexpr float kUnseen = -1e9F;

/// How much darker than both its sides the strip's column is where the line would be.
float darkness(const Strip& strip, const Pattern& pattern, int column, int middle) {
  const auto inner = strip.over(column, middle - pattern.half, middle + pattern.half);
  // A cell with its whole weight counts as one: pixels of full own share.
  if (inner.weight < 0.15F * static_cast<float>(2 * pattern.half + 1)) return kUnseen;
  const auto below = strip.over(column, middle - pattern.reach(), middle - pattern.gap);
  const auto above = strip.over(column, middle + pattern.gap, middle + pattern.reach());
  const float least = 0.15F * static_cast<float>(pattern.side);
  if (below.weight >= least && above.weight >= least) {
    // below.sum/below.weight and so on, with one division
    const float both = 2.0F * below.weight * above.weight;
    const float side = below.sum * above.weight + above.sum * below.weight;
    return (side * inner.weight - inner.sum * both) / (both * inner.weight);
  }
  if (below.weight < least && above.weight < least) return kUnseen;
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

Table fill_table(const std::vector<Strip>& strips, const Plan& plan, const Pattern& pattern) {
  Table table{plan.angles, pattern.tilts, plan.columns, {}};
  table.dark.resize(strips.size() * pattern.middle.size());
  float* dark = table.dark.data();
  for (const Strip& strip : strips) {
    const int* middle = pattern.middle.data();
    for (int t = 0; t < pattern.tilts; ++t)
      for (int column = 0; column < plan.columns; ++column)
        *dark++ = darkness(strip, pattern, column, *middle++);
  }
  return table;
}

/// Robust sd of the darkness of columns anywhere on the ball.
double spread(const Table& table) {
  std::vector<float> values;
  for (int angle = 0; angle < table.angles; ++angle)
    for (const float dark : table.columns(angle, table.tilts / 2))
      if (dark != kUnseen) values.push_back(std::abs(dark));
  if (values.size() < 50) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return 1.4826 * *middle;
}

struct Tally {
  double score = 0.0;
  double contrast = 0.0;
  int seen = 0;
};

Tally tally(std::span<const float> columns, double sd) {
  Tally result;
  const auto limit = static_cast<float>(kClip * sd);
  float clipped = 0.0F, sum = 0.0F;
  for (const float dark : columns) {
    if (dark == kUnseen) continue;
    ++result.seen;
    clipped += std::clamp(dark, -limit, limit);
    sum += dark;
  }
  if (result.seen == 0) return result;
  result.score = clipped / sd / std::sqrt(result.seen * 1.0);
  result.contrast = static_cast<double>(sum) / result.seen;
  return result;
}

double apart(double a, double b) { return std::abs(std::remainder(a - b, std::numbers::pi)); }

}  // namespace

LineSearch search_line(BallPixels& rows, Effort effort) {
  LineSearch search;
  const Cells cells(rows);
  search.saturated = cells.saturated();
  search.outside = cells.outside();
  const Plan plan = make_plan(cells.per_radius(), effort);
  const auto angle_of = [&](int k) { return std::numbers::pi * k / plan.angles; };
  std::vector<Strip> strips;
  for (int k = 0; k < plan.angles; ++k) strips.emplace_back(cells, plan, angle_of(k));
  std::vector<LinePeak> best(strips.size());
  std::vector<double> rank(best.size(), -1e30);
  for (const Pattern& pattern : plan.patterns) {
    const Table table = fill_table(strips, plan, pattern);
    const double sd = spread(table);
    if (!(sd > 0.0)) continue;
    for (int k = 0; k < plan.angles; ++k) {
      for (int t = 0; t < table.tilts; ++t) {
        const Tally found = tally(table.columns(k, t), sd);
        search.seen = std::max(search.seen, static_cast<double>(found.seen) / plan.columns);
        if (found.seen < plan.columns / 4) continue;
        // Among much alike the darker: a strong line makes every column count all it may.
        const double order = found.score + 0.3 * found.contrast / sd;
        const auto at = static_cast<std::size_t>(k);
        if (order <= rank[at]) continue;
        rank[at] = order;
        LinePeak& peak = best[at];
        peak.line.angle_rad = angle_of(k);
        peak.line.tilt_rad = tilt(t, table.tilts);
        peak.line.contrast = found.contrast;
        peak.line.shape.half_width = pattern.half_width;
        peak.score = found.score;
      }
    }
  }
  std::vector<std::size_t> order(best.size());
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return rank[a] > rank[b]; });
  constexpr double kApart = 8.0 * std::numbers::pi / 180.0;
  constexpr std::size_t kMaxPeaks = 4;
  for (const std::size_t k : order) {
    if (rank[k] < -1e29 || search.peaks.size() >= kMaxPeaks) break;
    const bool near = std::ranges::any_of(search.peaks, [&](const LinePeak& peak) {
      return apart(peak.line.angle_rad, best[k].line.angle_rad) < kApart;
    });
    if (!near) search.peaks.push_back(best[k]);
  }
  return search;
}

}  // namespace strobe::digitize
