#include "host/digitize/surface/edge_line.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "common/geometry/leg.hpp"
#include "host/digitize/core/statistics.hpp"

namespace strobe::digitize {

int profile_count(const Photograph& photograph) {
  return std::min(kMaxProfiles, std::max(16, photograph.width() / kProfileColumns));
}

int profile_column(const Photograph& photograph, int profile) {
  return static_cast<int>((profile + 0.5) * photograph.width() / profile_count(photograph));
}

std::optional<EdgeSamples> samples_across(const Photograph& photograph, const OcclusionMask& occluded,
                                          int column, double row) {
  constexpr int kReach = kProfileHalfReach_px, kHalf = kProfileColumns / 2;
  if (!(row > 0.0 && row < photograph.height())) return std::nullopt;
  EdgeSamples samples;
  samples.top = static_cast<int>(std::lround(row)) - kReach;
  if (samples.top < 0 || samples.top + 2 * kReach >= photograph.height()) return std::nullopt;
  if (column < kHalf || column + kHalf >= photograph.width()) return std::nullopt;
  for (int k = 0; k <= 2 * kReach; k += kReach / 2) {
    for (const int side : {-kHalf, kHalf})
      if (occluded.at(column + side, samples.top + k)) return std::nullopt;
  }
  const double full = kSaturatedShare * static_cast<double>(photograph.saturation);
  for (int k = 0; k <= 2 * kReach; ++k) {
    const float* values = photograph.intensity.ptr<float>(samples.top + k) + column - kHalf;
    double& mean = samples.intensity[static_cast<std::size_t>(k)];
    mean = std::accumulate(values, values + kProfileColumns, 0.0) / kProfileColumns;
    if (*std::max_element(values, values + kProfileColumns) >= full) mean = std::max(mean, full);
  }
  return samples;
}

namespace {

constexpr double kMaxSlope = 0.36;  // 20 degrees
constexpr int kSlopes = 145;
constexpr double kSlopeStep = 2.0 * kMaxSlope / (kSlopes - 1);
constexpr int kVoteReach = 8;  // slopes to either side of an edge point's own
constexpr int kSmallWidth = 720;

double hough_scale(cv::Size photograph) {
  return std::max(1.0, static_cast<double>(photograph.width) / kSmallWidth);
}

/// Noise level of the gradients, from their distribution.
float typical_edge(const cv::Mat& gradient) {
  std::vector<float> values;
  for (int row = 0; row < gradient.rows; row += 2) {
    const auto* g = gradient.ptr<float>(row);
    for (int column = 0; column < gradient.cols; column += 2) values.push_back(std::abs(g[column]));
  }
  return std::max(quantile(std::move(values), 7, 10), 1e-6F);
}

class Accumulator {
 public:
  explicit Accumulator(const cv::Mat& light) : size_(light.size()) {
    reach_ = static_cast<int>(std::ceil(0.5 * kMaxSlope * size_.width)) + 2;
    rows_ = size_.height + 2 * reach_;
    votes_ = cv::Mat::zeros(kSlopes, rows_, CV_32FC1);
  }

  void add(double column, double row, double slope, float weight) {
    const int middle = static_cast<int>(std::lround((slope + kMaxSlope) / kSlopeStep));
    for (int k = std::max(0, middle - kVoteReach); k <= std::min(kSlopes - 1, middle + kVoteReach); ++k) {
      const double at = row - (k * kSlopeStep - kMaxSlope) * (column - 0.5 * size_.width) + reach_;
      const int bin = static_cast<int>(at);
      if (bin < 0 || bin + 1 >= rows_) continue;
      const auto part = static_cast<float>(at - bin);
      float* v = votes_.ptr<float>(k);
      v[bin] += weight * (1.0F - part);
      v[bin + 1] += weight * part;
    }
  }

  std::vector<HoughLine> best(std::size_t max_lines, double scale) {
    std::vector<HoughLine> lines;
    while (lines.size() < max_lines) {
      double top = 0.0;
      cv::Point at;
      cv::minMaxLoc(votes_, nullptr, &top, nullptr, &at);
      if (top < 0.04 * size_.width) break;
      HoughLine line;
      line.slope = at.y * kSlopeStep - kMaxSlope;
      line.row_px = (at.x - reach_ + 0.5) * scale - 0.5;
      line.votes = top / size_.width;
      lines.push_back(line);
      clear_around(at);
    }
    return lines;
  }

 private:
  void clear_around(cv::Point at) {
    for (int k = std::max(0, at.y - 6); k <= std::min(kSlopes - 1, at.y + 6); ++k) {
      float* v = votes_.ptr<float>(k);
      for (int bin = std::max(0, at.x - 2); bin <= std::min(rows_ - 1, at.x + 2); ++bin) v[bin] = 0.0F;
    }
  }

  cv::Size size_;
  int reach_ = 0, rows_ = 0;
  cv::Mat votes_;
};

}  // namespace

cv::Size hough_image_size(cv::Size photograph) {
  const double scale = hough_scale(photograph);
  return {std::max(8, static_cast<int>(std::lround(photograph.width / scale))),
          std::max(8, static_cast<int>(std::lround(photograph.height / scale)))};
}

std::vector<HoughLine> hough_lines(const Photograph& photograph, const OcclusionMask& occluded,
                                   std::size_t max_lines) {
  cv::Mat light, smooth, gx, gy;
  cv::resize(photograph.intensity, light, hough_image_size(photograph.intensity.size()), 0, 0,
             cv::INTER_AREA);
  cv::GaussianBlur(light, smooth, {}, 1.0);
  cv::Scharr(smooth, gx, CV_32F, 1, 0, 1.0 / 32.0);
  cv::Scharr(smooth, gy, CV_32F, 0, 1, 1.0 / 32.0);
  const float edge = 3.0F * typical_edge(gy);
  Accumulator votes(light);
  for (int row = 2; row + 2 < gy.rows; ++row) {
    const auto* x = gx.ptr<float>(row);
    const auto* y = gy.ptr<float>(row);
    const auto* above = gy.ptr<float>(row - 1);
    const auto* below = gy.ptr<float>(row + 1);
    const uchar* mask = occluded.mask.empty() ? nullptr : occluded.mask.ptr<uchar>(row);
    for (int column = 2; column + 2 < gy.cols; ++column) {
      if (y[column] < edge || y[column] < above[column] || y[column] <= below[column]) continue;
      if (mask != nullptr && mask[column] != 0) continue;
      const double slope = -x[column] / y[column];
      if (std::abs(slope) > kMaxSlope + kVoteReach * kSlopeStep) continue;
      const double bend = above[column] - 2.0 * y[column] + below[column];
      const double part = bend < 0.0 ? 0.5 * (above[column] - below[column]) / bend : 0.0;
      votes.add(column, row + part, slope, std::min(1.0F, y[column] / (2.0F * edge)));
    }
  }
  return votes.best(max_lines, hough_scale(photograph.intensity.size()));
}

namespace {

constexpr int kHalfReach = kProfileHalfReach_px;  // to either side of the Hough line
constexpr int kHalfStep = 2;
constexpr int kBlocks = 12;  // of profiles with correlated errors

struct EdgeCrossing {
  cv::Point2d plane;
  double rise = 0.0;
  int profile = 0;
};

/// The steepest rise, with sub-pixel position by a parabola.
std::optional<EdgeCrossing> steepest(const std::array<double, 2 * kHalfReach + 1>& intensity, int column,
                                     int top) {
  const int n = 2 * kHalfReach + 1;
  int best = -1;
  double most = 0.0;
  const auto at = [&](int k) { return intensity[static_cast<std::size_t>(k)]; };
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
  return EdgeCrossing{{static_cast<double>(column), top + best + part}, most, 0};
}

std::vector<EdgeCrossing> crossings(const Photograph& photograph, const PlaneMap& map,
                                    const OcclusionMask& occluded, const HoughLine& start, int& tried) {
  std::vector<EdgeCrossing> found;
  const int count = profile_count(photograph);
  for (int i = 0; i < count; ++i) {
    const int column = profile_column(photograph, i);
    const double row = start.row_px + start.slope * (column - 0.5 * photograph.width());
    const auto samples = samples_across(photograph, occluded, column, row);
    if (!samples) continue;
    ++tried;
    auto crossing = steepest(samples->intensity, column, samples->top);
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

/// The line through two crossings with the most inliers (RANSAC).
Line ransac_line(const std::vector<EdgeCrossing>& found) {
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
    const auto agree = std::count_if(found.begin(), found.end(), [&](const EdgeCrossing& c) {
      return std::abs(line.off(c.plane)) < kInlier_px;
    });
    if (agree > most) {
      most = static_cast<int>(agree);
      best = line;
    }
  }
  return best;
}

Line least_squares(const std::vector<EdgeCrossing>& inliers) {
  geometry::LinearRegression<double> fit;
  for (const EdgeCrossing& c : inliers) fit.add(c.plane.x, c.plane.y, 1.0);
  return {fit.mean_x(), fit.mean(), fit.moment() > 0.0 ? fit.slope() : 0.0};
}

/// Standard deviations from the means of blocks, as neighbouring profiles' errors are correlated by the
/// edge's texture.
void set_sd(const std::vector<EdgeCrossing>& inliers, const Line& line, EdgeLine& edge) {
  std::array<double, kBlocks> sum{}, count{};
  double squares = 0.0, sxx = 0.0;
  for (const EdgeCrossing& c : inliers) {
    const double off = line.off(c.plane);
    squares += off * off;
    sxx += (c.plane.x - line.x0) * (c.plane.x - line.x0);
    const auto block = static_cast<std::size_t>(c.profile * kBlocks / kMaxProfiles) % kBlocks;
    sum[block] += off;
    count[block] += 1.0;
  }
  const auto n = static_cast<double>(inliers.size());
  const double rms = std::sqrt(squares / std::max(1.0, n - 2.0));
  double blocks = 0.0, between = 0.0;
  for (std::size_t b = 0; b < kBlocks; ++b) {
    if (count[b] < 1.0) continue;
    blocks += 1.0;
    between += sum[b] * sum[b];  // weighted by count²: of the grand mean
  }
  const double grand = std::sqrt(between * std::max(1.0, blocks / std::max(1.0, blocks - 2.0))) / n;
  edge.sd_px = std::hypot(std::max(grand, rms / std::sqrt(n)), kEdgeFloor_px);
  edge.slope_sd = edge.sd_px * std::sqrt(n / std::max(1.0, sxx));
}

}  // namespace

std::optional<EdgeLine> fit_edge_line(const Photograph& photograph, const PlaneMap& map,
                                      const OcclusionMask& occluded, const HoughLine& start) {
  int tried = 0;
  const std::vector<EdgeCrossing> found = crossings(photograph, map, occluded, start, tried);
  if (found.size() < 12) return std::nullopt;
  Line line = ransac_line(found);
  std::vector<EdgeCrossing> inliers;
  for (int round = 0; round < 3; ++round) {
    inliers.clear();
    for (const EdgeCrossing& c : found) {
      if (std::abs(line.off(c.plane)) < kInlier_px) inliers.push_back(c);
    }
    if (inliers.size() < 12) return std::nullopt;
    line = least_squares(inliers);
  }
  EdgeLine edge;
  edge.middle = {line.x0, line.y0};
  edge.slope = line.slope;
  double least = inliers.front().plane.x, most = least;
  std::vector<double> rises;
  for (const EdgeCrossing& c : inliers) {
    least = std::min(least, c.plane.x);
    most = std::max(most, c.plane.x);
    rises.push_back(c.rise);
  }
  edge.half_span = 0.5 * (most - least);
  edge.visible_fraction = static_cast<double>(inliers.size()) / std::max(1, tried);
  edge.visible_px = static_cast<double>(inliers.size()) / std::max(1, tried) * (most - least);
  edge.contrast = upper_median(std::move(rises));
  set_sd(inliers, line, edge);
  return edge;
}

}  // namespace strobe::digitize
