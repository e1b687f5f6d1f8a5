#include "host/digitize/equator_search.hpp"

#include <algorithm>
#include <numbers>

namespace strobe::digitize {
namespace {

constexpr double kInner = 0.95;
constexpr int kMostCells = 44;     ///< a radius
constexpr double kAcross = 0.62;   ///< how far from the middle a strip reaches, radii
constexpr int kColumns = 40;       ///< along a strip
constexpr double kTiltMost = 0.3;  ///< 5 degrees of tilt, and what perspective adds off the axis

constexpr double kClip = 2.5;  ///< sd that one column may count
/// A narrow line needs its tilt known the better.
struct Width {
  double half = 0.0;
  int tilts = 1;
};
constexpr std::array kWidths{Width{0.022, 9}, Width{0.045, 7}, Width{0.09, 5}};

/// The disc in square cells: brightness relative to the ball's own, weighted.
class Cells {
 public:
  Cells(const Blocks& blocks, const Flattened& flattened, const Disc& disc, const Shading& shading)
      : per_radius_(std::clamp(static_cast<int>(disc.radius_image_px / blocks.stride / 1.4), 4, kMostCells)),
        side_(2 * per_radius_ + 1),
        sum_(static_cast<std::size_t>(side_ * side_)),
        weight_(sum_.size()) {
    fill(blocks, flattened, disc, shading);
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
  void fill(const Blocks& blocks, const Flattened& flattened, const Disc& disc, const Shading& shading);

  int per_radius_;
  int side_;
  std::vector<float> sum_;
  std::vector<float> weight_;
  double saturated_ = 0.0;
  double outside_ = 0.0;
};

void Cells::fill(const Blocks& blocks, const Flattened& flattened, const Disc& disc, const Shading& shading) {
  const cv::Rect box = blocks.around(disc, kInner);
  const float middle = std::max(1e-6F, shading.at(0.0F, 0.0F, 1.0F));
  const float floor = 0.05F * middle;
  const double radius = disc.radius_image_px / blocks.stride;
  const auto share = static_cast<float>(per_radius_ * per_radius_ / (radius * radius));  // of a cell
  int inside = 0, full = 0;
  for (int j = box.y; j < box.y + box.height; ++j) {
    const float* left = flattened.left.ptr<float>(j);
    const float* noise = flattened.noise.ptr<float>(j);
    const float* light = blocks.light.ptr<float>(j);
    for (int i = box.x; i < box.x + box.width; ++i) {
      const cv::Point2d unit = disc.unit(blocks.column(i), blocks.row(j));
      const double r = unit.dot(unit);
      if (r > kInner * kInner) continue;
      ++inside;
      if (light[i] >= blocks.saturation) ++full;
      if (noise[i] < 0.0F) continue;
      const float own = shading.at(static_cast<float>(unit.x), static_cast<float>(unit.y),
                                   static_cast<float>(std::sqrt(1.0 - r)));
      if (own <= floor) continue;
      // Least squares for left = own * (1 + x) with noise in proportion to sqrt(noise): sums of own*left and
      // own².
      const float scale = share / (noise[i] + floor * floor);
      const std::size_t at = index(unit.x, unit.y);
      sum_[at] += left[i] * own * scale;
      weight_[at] += own * own * scale;
    }
  }
  const double whole = CV_PI * kInner * kInner * radius * radius;
  saturated_ = full / std::max(1.0, whole);
  outside_ = std::clamp(1.0 - inside / whole, 0.0, 1.0);
}

/// Sums along columns across a strip, so that any stretch costs two look-ups.
class Strip {
 public:
  Strip(const Cells& cells, double angle) : half_(static_cast<int>(kAcross * cells.per_radius())) {
    const auto rows = static_cast<std::size_t>(2 * half_ + 2);
    sum_.resize(kColumns * rows);
    weight_.resize(kColumns * rows);
    const double c = std::cos(angle), s = std::sin(angle);
    for (int column = 0; column < kColumns; ++column) {
      const double a = along(column);
      const double most = std::sqrt(kInner * kInner - a * a);
      std::size_t at = static_cast<std::size_t>(column) * rows;
      for (int k = -half_; k <= half_; ++k, ++at) {
        const double across = static_cast<double>(k) / cells.per_radius();
        sum_[at + 1] = sum_[at];
        weight_[at + 1] = weight_[at];
        if (std::abs(across) > most) continue;
        const std::size_t cell = cells.index(c * a - s * across, s * a + c * across);
        sum_[at + 1] += cells.sum(cell);
        weight_[at + 1] += cells.weight(cell);
      }
    }
  }

  static double along(int column) { return 0.94 * (2.0 * (column + 0.5) / kColumns - 1.0); }

  struct Mean {
    float sum = 0.0F;
    float weight = 0.0F;
  };
  /// Over cells from `low` to `high` across, both included.
  Mean over(int column, int low, int high) const {
    low = std::max(low, -half_);
    high = std::min(high, half_);
    if (low > high) return {};
    const std::size_t base = static_cast<std::size_t>(column * (2 * half_ + 2) + half_);
    const std::size_t from = base + static_cast<std::size_t>(low + 0);
    const std::size_t to = base + static_cast<std::size_t>(high + 1);
    return {sum_[to] - sum_[from], weight_[to] - weight_[from]};
  }

 private:
  int half_;
  std::vector<float> sum_;
  std::vector<float> weight_;
};

constexpr float kUnseen = -1e9F;

/// How much darker than both its sides the strip's column is where the line would be.
float darkness(const Strip& strip, int column, double middle, double half_width, int per_radius) {
  const int centre = static_cast<int>(std::lround(middle * per_radius));
  const int half = std::max(0, static_cast<int>(std::lround(half_width * per_radius - 0.5)));
  const int gap = half + 2, width = std::max(2, half + 1);
  const auto inner = strip.over(column, centre - half, centre + half);
  const auto below = strip.over(column, centre - gap - width + 1, centre - gap);
  const auto above = strip.over(column, centre + gap, centre + gap + width - 1);
  const float cells = static_cast<float>(2 * half + 1);
  // A cell with its whole weight counts as one: pixels of full own share.
  if (inner.weight < 0.15F * cells) return kUnseen;
  float side = 0.0F, sides = 0.0F;
  for (const auto& one : {below, above}) {
    if (one.weight < 0.15F * static_cast<float>(width)) continue;
    side += one.sum / one.weight;
    sides += 1.0F;
  }
  if (sides == 0.0F) return kUnseen;
  return side / sides - inner.sum / inner.weight;
}

double tilt(int index, int tilts) { return kTiltMost * (2.0 * index / (tilts - 1) - 1.0); }

/// Darkness of every column of every strip and tilt, for one width.
struct Table {
  int angles = 0;
  int tilts = 0;
  std::vector<float> dark;  ///< [angle][tilt][column]

  const float* columns(int angle, int tilt_index) const {
    return dark.data() + static_cast<std::size_t>((angle * tilts + tilt_index) * kColumns);
  }
};

Table fill_table(const std::vector<Strip>& strips, const Width& width, int per_radius) {
  Table table;
  table.tilts = width.tilts;
  table.angles = static_cast<int>(strips.size());
  table.dark.reserve(strips.size() * static_cast<std::size_t>(width.tilts * kColumns));
  for (const Strip& strip : strips) {
    for (int t = 0; t < width.tilts; ++t) {
      const double tangent = std::tan(tilt(t, width.tilts));
      for (int column = 0; column < kColumns; ++column) {
        const double a = Strip::along(column);
        const double z = std::sqrt((1.0 - a * a) / (1.0 + tangent * tangent));
        table.dark.push_back(darkness(strip, column, tangent * z, width.half, per_radius));
      }
    }
  }
  return table;
}

/// Robust sd of the darkness of columns anywhere on the ball.
double spread(const Table& table) {
  std::vector<float> values;
  for (int angle = 0; angle < table.angles; ++angle) {
    const float* columns = table.columns(angle, table.tilts / 2);
    for (int column = 0; column < kColumns; ++column)
      if (columns[column] != kUnseen) values.push_back(std::abs(columns[column]));
  }
  if (values.size() < 50) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return 1.4826 * *middle;
}

struct Tally {
  double score = 0.0;
  double contrast = 0.0;
  double share = 0.0;
  int seen = 0;
};

Tally tally(const float* columns, double sd) {
  Tally result;
  double clipped = 0.0, sum = 0.0;
  for (int column = 0; column < kColumns; ++column) {
    if (columns[column] == kUnseen) continue;
    ++result.seen;
    clipped += std::clamp(columns[column] / sd, -kClip, kClip);
    sum += columns[column];
  }
  if (result.seen == 0) return result;
  result.score = clipped / std::sqrt(result.seen * 1.0);
  result.contrast = sum / result.seen;
  int dark = 0;
  for (int column = 0; column < kColumns; ++column)
    if (columns[column] != kUnseen && columns[column] > 0.4 * result.contrast) ++dark;
  result.share = static_cast<double>(dark) / result.seen;
  return result;
}

double apart(double a, double b) { return std::abs(std::remainder(a - b, std::numbers::pi)); }

}  // namespace

LineSearch search_line(const Blocks& blocks, const Flattened& flattened, const Disc& disc,
                       const Shading& shading, Effort effort) {
  LineSearch search;
  const Cells cells(blocks, flattened, disc, shading);
  search.saturated = cells.saturated();
  search.outside = cells.outside();
  const int angles = effort == Effort::fast ? 60 : 90;
  std::vector<Strip> strips;
  for (int k = 0; k < angles; ++k) strips.emplace_back(cells, std::numbers::pi * k / angles);
  std::vector<LinePeak> best(static_cast<std::size_t>(angles));
  std::vector<double> rank(best.size(), -1e30);
  for (const Width& width : kWidths) {
    if (width.half * cells.per_radius() < 0.4) continue;
    const Table table = fill_table(strips, width, cells.per_radius());
    const double sd = spread(table);
    if (!(sd > 0.0)) continue;
    for (int k = 0; k < angles; ++k) {
      for (int t = 0; t < table.tilts; ++t) {
        const Tally found = tally(table.columns(k, t), sd);
        search.seen = std::max(search.seen, static_cast<double>(found.seen) / kColumns);
        if (found.seen < kColumns / 4) continue;
        // Among much alike the darker: a strong line makes every column count all it may.
        const double order = found.score + 0.3 * found.contrast / sd;
        const auto at = static_cast<std::size_t>(k);
        if (order <= rank[at]) continue;
        rank[at] = order;
        LinePeak& peak = best[at];
        peak.line.angle_rad = std::numbers::pi * k / angles;
        peak.line.tilt_rad = tilt(t, table.tilts);
        peak.line.contrast = found.contrast;
        peak.line.shape.half_width = width.half;
        peak.score = found.score;
        peak.share = found.share;
      }
    }
  }
  std::vector<std::size_t> order(best.size());
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return rank[a] > rank[b]; });
  constexpr double kApart = 8.0 * std::numbers::pi / 180.0;
  constexpr std::size_t kMostPeaks = 4;
  for (const std::size_t k : order) {
    if (rank[k] < -1e29 || search.peaks.size() >= kMostPeaks) break;
    const bool near = std::ranges::any_of(search.peaks, [&](const LinePeak& peak) {
      return apart(peak.line.angle_rad, best[k].line.angle_rad) < kApart;
    });
    if (!near) search.peaks.push_back(best[k]);
  }
  return search;
}

}  // namespace strobe::digitize
