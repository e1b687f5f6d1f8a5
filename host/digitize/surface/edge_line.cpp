#include "host/digitize/surface/edge_line.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "host/digitize/core/median.hpp"

namespace strobe::digitize {
namespace {

constexpr int kProfiles = 240;
constexpr int kHalfReach = 10;  // px to either side of the rough line
constexpr int kAlong = 5;       // columns averaged for one profile
constexpr int kHalfStep = 2;
constexpr int kBlocks = 12;  // of neighbouring profiles, whose errors go together
constexpr double kAgree_px = 1.5;
constexpr double kFloor_px = 0.03;

struct Crossing {
  cv::Point2d plane;
  double rise = 0.0;
  int profile = 0;
};

/// Light on the columns around, down the rows through the rough line.
bool profile(const Photograph& photograph, const OcclusionMask& hidden, int column, double row,
             std::array<double, 2 * kHalfReach + 1>& light) {
  const int top = static_cast<int>(std::lround(row)) - kHalfReach;
  if (top < 0 || top + 2 * kHalfReach >= photograph.height()) return false;
  if (column < kAlong / 2 || column + kAlong / 2 >= photograph.width()) return false;
  for (int k = 0; k <= 2 * kHalfReach; k += kHalfReach / 2) {
    if (hidden.at(column - kAlong / 2, top + k) || hidden.at(column + kAlong / 2, top + k)) return false;
  }
  for (int k = 0; k <= 2 * kHalfReach; ++k) {
    const float* row_light = photograph.light.ptr<float>(top + k) + column - kAlong / 2;
    light[static_cast<std::size_t>(k)] = std::accumulate(row_light, row_light + kAlong, 0.0) / kAlong;
  }
  return true;
}

/// The place of the half height of the greatest rise: robust against what lies on either side of the edge.
std::optional<Crossing> steepest(const std::array<double, 2 * kHalfReach + 1>& light, int column, int top) {
  const int n = 2 * kHalfReach + 1;
  int best = -1;
  double most = 0.0;
  const auto at = [&](int k) { return light[static_cast<std::size_t>(k)]; };
  for (int k = kHalfStep; k + kHalfStep < n; ++k) {
    const double rise = at(k + kHalfStep) - at(k - kHalfStep);
    if (rise > most) {
      most = rise;
      best = k;
    }
  }
  if (best < kHalfStep + 1 || best + kHalfStep + 1 >= n) return std::nullopt;
  const double before = at(best - 1 + kHalfStep) - at(best - 1 - kHalfStep);
  const double after = at(best + 1 + kHalfStep) - at(best + 1 - kHalfStep);
  const double bend = before - 2.0 * most + after;
  const double part = bend < 0.0 ? std::clamp(0.5 * (before - after) / bend, -1.0, 1.0) : 0.0;
  return Crossing{{static_cast<double>(column), top + best + part}, most, 0};
}

std::vector<Crossing> crossings(const Photograph& photograph, const PlaneMap& map,
                                const OcclusionMask& hidden, const HoughLine& rough, int& looked) {
  std::vector<Crossing> found;
  const int count = std::min(kProfiles, std::max(16, photograph.width() / kAlong));
  std::array<double, 2 * kHalfReach + 1> light{};
  for (int i = 0; i < count; ++i) {
    const int column = static_cast<int>((i + 0.5) * photograph.width() / count);
    const double row = rough.row_px + rough.slope * (column - 0.5 * photograph.width());
    if (!profile(photograph, hidden, column, row, light)) continue;
    ++looked;
    auto crossing = steepest(light, column, static_cast<int>(std::lround(row)) - kHalfReach);
    if (!crossing) continue;
    crossing->plane = map.to_plane(crossing->plane);
    crossing->profile = i;
    found.push_back(*crossing);
  }
  return found;
}

struct Line {
  double x0 = 0.0, y0 = 0.0, slope = 0.0;
  double off(cv::Point2d p) const { return p.y - y0 - slope * (p.x - x0); }
};

/// The line through two of the crossings that most others agree with.
Line consensus(const std::vector<Crossing>& found) {
  Line best;
  int most = -1;
  std::uint64_t state = 1;
  const auto draw = [&] {
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<std::size_t>(state >> 33) % found.size();
  };
  for (int trial = 0; trial < 200; ++trial) {
    const cv::Point2d a = found[draw()].plane, b = found[draw()].plane;
    if (std::abs(a.x - b.x) < 1.0) continue;
    const Line line{a.x, a.y, (b.y - a.y) / (b.x - a.x)};
    const auto agree = std::count_if(found.begin(), found.end(), [&](const Crossing& c) {
      return std::abs(line.off(c.plane)) < kAgree_px;
    });
    if (agree > most) {
      most = static_cast<int>(agree);
      best = line;
    }
  }
  return best;
}

Line least_squares(const std::vector<Crossing>& found) {
  Line line;
  const auto n = static_cast<double>(found.size());
  for (const Crossing& c : found) {
    line.x0 += c.plane.x / n;
    line.y0 += c.plane.y / n;
  }
  double sxx = 0.0, sxy = 0.0;
  for (const Crossing& c : found) {
    sxx += (c.plane.x - line.x0) * (c.plane.x - line.x0);
    sxy += (c.plane.x - line.x0) * (c.plane.y - line.y0);
  }
  line.slope = sxx > 0.0 ? sxy / sxx : 0.0;
  return line;
}

/// Neighbouring profiles err together (texture of the plate's edge): the sd of the means of blocks.
void spread(const std::vector<Crossing>& agreed, const Line& line, EdgeLine& edge) {
  std::array<double, kBlocks> sum{}, count{};
  double squares = 0.0, sxx = 0.0;
  for (const Crossing& c : agreed) {
    const double off = line.off(c.plane);
    squares += off * off;
    sxx += (c.plane.x - line.x0) * (c.plane.x - line.x0);
    const auto block = static_cast<std::size_t>(c.profile * kBlocks / kProfiles) % kBlocks;
    sum[block] += off;
    count[block] += 1.0;
  }
  const auto n = static_cast<double>(agreed.size());
  edge.rms_px = std::sqrt(squares / std::max(1.0, n - 2.0));
  double blocks = 0.0, between = 0.0;
  for (std::size_t b = 0; b < kBlocks; ++b) {
    if (count[b] < 1.0) continue;
    blocks += 1.0;
    between += sum[b] * sum[b];  // weighted by count²: of the grand mean
  }
  const double grand = std::sqrt(between * std::max(1.0, blocks / std::max(1.0, blocks - 2.0))) / n;
  edge.sd_px = std::hypot(std::max(grand, edge.rms_px / std::sqrt(n)), kFloor_px);
  edge.slope_sd = edge.sd_px * std::sqrt(n / std::max(1.0, sxx));
}

}  // namespace

std::optional<EdgeLine> fit_edge_line(const Photograph& photograph, const PlaneMap& map,
                                      const OcclusionMask& hidden, const HoughLine& rough) {
  int looked = 0;
  const std::vector<Crossing> found = crossings(photograph, map, hidden, rough, looked);
  if (found.size() < 12) return std::nullopt;
  Line line = consensus(found);
  std::vector<Crossing> agreed;
  for (int round = 0; round < 3; ++round) {
    agreed.clear();
    for (const Crossing& c : found) {
      if (std::abs(line.off(c.plane)) < kAgree_px) agreed.push_back(c);
    }
    if (agreed.size() < 12) return std::nullopt;
    line = least_squares(agreed);
  }
  EdgeLine edge;
  edge.middle = {line.x0, line.y0};
  edge.slope = line.slope;
  double least = agreed.front().plane.x, most = least;
  std::vector<double> rises;
  for (const Crossing& c : agreed) {
    least = std::min(least, c.plane.x);
    most = std::max(most, c.plane.x);
    rises.push_back(c.rise);
  }
  edge.half_span = 0.5 * (most - least);
  edge.visible_fraction = static_cast<double>(agreed.size()) / std::max(1, looked);
  edge.seen_px = static_cast<double>(agreed.size()) / std::max(1, looked) * (most - least);
  edge.contrast = upper_median(std::move(rises));
  spread(agreed, line, edge);
  return edge;
}

}  // namespace strobe::digitize
