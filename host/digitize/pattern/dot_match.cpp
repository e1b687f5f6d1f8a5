#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/attitude/attitude_spin.hpp"
#include "host/digitize/core/statistics.hpp"
#include "host/digitize/pattern/dot_pattern.hpp"

namespace strobe::digitize {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Matrix26d = Eigen::Matrix<double, 2, 6>;

// Dots that are nearer to each other give no attitude, and attitudes that are nearer are one.
constexpr double kApart_rad = 0.3;
// Two dots give an attitude to this sd [radii]; more of them to what pattern and outline are, and no better
// than this.
constexpr double kPairSd = 0.035, kFinestSd = 0.012;
// Of the dots that are surely seen one in ten is missed.
constexpr double kMissed = std::numbers::ln10;
// Of dark spots that are no dots, print and dirt, there are some five on a disc.
constexpr double kOthers = 5.0;
constexpr int kMinMatched = static_cast<int>(kMinPatternDots);
constexpr std::size_t kMaxRefined = 40;

Vector3d direction(const Vector2d& at) {
  return {at.x(), at.y(), std::sqrt(std::max(0.0, 1.0 - at.squaredNorm()))};
}

struct Match {
  std::size_t seen = 0, dot = 0;
};

struct Hypothesis {
  Matrix3d attitude;
  double score = 0.0;  ///< log likelihood ratio against chance
  std::vector<Match> matches;
};

/// Each dot of the pattern with the seen one nearest to where it should be, to `sd`, one to one.
void score(Hypothesis& h, const std::vector<SeenDot>& seen, const DotPattern& pattern, double sd) {
  struct Near {
    double squared;
    Match match;
  };
  std::vector<Near> near;
  std::vector<Vector3d> turned;
  for (const Vector3d& dot : pattern.dots) turned.push_back(h.attitude * dot);
  const double farthest = kFarthest_sd * sd * kFarthest_sd * sd;
  const double matched = -std::log(2.0 * kOthers * sd * sd);  // density about the dot over that of others
  for (std::size_t d = 0; d < turned.size(); ++d) {
    if (turned[d].z() < 0.0) continue;
    for (std::size_t s = 0; s < seen.size(); ++s)
      if (const double squared = (seen[s].at - turned[d].head<2>()).squaredNorm(); squared < farthest)
        near.push_back({squared, {s, d}});
  }
  std::ranges::stable_sort(near, {}, &Near::squared);
  h.score = 0.0;
  h.matches.clear();
  std::vector<bool> taken(seen.size(), false), found(turned.size(), false);
  for (const auto& [squared, match] : near) {
    if (taken[match.seen] || found[match.dot]) continue;
    taken[match.seen] = found[match.dot] = true;
    h.matches.push_back(match);
    h.score += matched - 0.5 * squared / (sd * sd);
  }
  for (std::size_t d = 0; d < turned.size(); ++d)
    if (!found[d] && turned[d].z() > 0.0 && turned[d].head<2>().norm() < kSurelySeen) h.score -= kMissed;
}

/// The rotation that brings the pattern's dots nearest to the seen ones (Kabsch 1976).
Matrix3d kabsch(const std::vector<Match>& matches, const std::vector<SeenDot>& seen,
                const DotPattern& pattern) {
  Matrix3d sum = Matrix3d::Zero();
  for (const Match& m : matches) sum += direction(seen[m.seen].at) * pattern.dots[m.dot].transpose();
  const Eigen::JacobiSVD<Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d sign = Matrix3d::Identity();
  sign(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() > 0.0 ? 1.0 : -1.0;
  return svd.matrixU() * sign * svd.matrixV().transpose();
}

double angle_between(const Matrix3d& a, const Matrix3d& b) {
  return attitude::rotation_vector_rad(a * b.transpose()).norm();
}

Matrix3d frame_of(const Vector3d& a, const Vector3d& b) {
  Matrix3d frame;
  frame.col(0) = (a + b).normalized();
  frame.col(1) = (a - b).normalized();
  frame.col(2) = frame.col(0).cross(frame.col(1));
  return frame;
}

/// From all pairs of seen dots and those of the pattern that are as far apart.
std::vector<Hypothesis> hypotheses(const std::vector<SeenDot>& seen, const DotPattern& pattern) {
  std::vector<Hypothesis> all;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    for (std::size_t j = i + 1; j < seen.size(); ++j) {
      const Vector3d a = direction(seen[i].at), b = direction(seen[j].at);
      const double apart = std::acos(std::clamp(a.dot(b), -1.0, 1.0));
      if (apart < kApart_rad) continue;
      const Matrix3d to = frame_of(a, b);
      for (std::size_t k = 0; k < pattern.dots.size(); ++k) {
        for (std::size_t l = 0; l < pattern.dots.size(); ++l) {
          const Vector3d &p = pattern.dots[k], &q = pattern.dots[l];
          if (k == l || std::abs(std::acos(std::clamp(p.dot(q), -1.0, 1.0)) - apart) > kFarthest_sd * kPairSd)
            continue;
          Hypothesis h{to * frame_of(p, q).transpose(), 0.0, {}};
          score(h, seen, pattern, kPairSd);
          if (h.matches.size() >= 3) all.push_back(std::move(h));
        }
      }
    }
  }
  std::ranges::stable_sort(all, std::ranges::greater{}, &Hypothesis::score);
  return all;
}

/// The best of them, refined, each another attitude, best first.
std::vector<Hypothesis> distinct(std::vector<Hypothesis> all, const std::vector<SeenDot>& seen,
                                 const DotPattern& pattern, double sd) {
  std::vector<Hypothesis> best;
  for (Hypothesis& h : all) {
    const auto same = [&](const Hypothesis& other) {
      return angle_between(h.attitude, other.attitude) < kApart_rad;
    };
    if (std::ranges::any_of(best, same)) continue;
    for (const double now : {kPairSd, std::sqrt(kPairSd * sd), sd, sd}) {
      if (h.matches.size() < 3) break;
      h.attitude = kabsch(h.matches, seen, pattern);
      score(h, seen, pattern, now);
    }
    if (!std::ranges::any_of(best, same)) best.push_back(std::move(h));
    if (best.size() >= kMaxRefined) break;
  }
  std::ranges::stable_sort(best, std::ranges::greater{}, &Hypothesis::score);
  return best;
}

/// Least squares for a small turn, the outline's middle and its relative radius: where a dot is seen follows
/// from its direction n as (1 + s)·(n_x, n_y) + (c_x, c_y).
class AttitudeFit {
 public:
  AttitudeFit(const std::vector<SeenDot>& seen, const DotPattern& pattern, const DotMatchSettings& settings,
              Hypothesis start)
      : seen_(seen),
        pattern_(pattern),
        settings_(settings),
        matches_(std::move(start.matches)),
        attitude_(start.attitude) {}

  std::optional<BallAttitude> run() {
    for (int round = 0; round < 4; ++round) {
      for (int step = 0; step < 8; ++step)
        if (!improve()) return std::nullopt;
      const std::size_t before = matches_.size();
      std::erase_if(matches_, [&](const Match& m) {
        return squared(m) > kFarthest_sd * kFarthest_sd * std::max(1.0, reduced());
      });
      if (matches_.size() == before) break;
    }
    if (std::ssize(matches_) < kMinMatched) return std::nullopt;
    return result();
  }

 private:
  struct Row {
    Vector2d residual;
    Matrix2d covariance;
    Matrix26d design;
  };

  Row row(const Match& m) const {
    const Vector3d n = attitude_ * pattern_.dots[m.dot];
    const double scale = 1.0 + relative_;
    Row r;
    r.residual = seen_[m.seen].at - scale * n.head<2>() - centre_;
    const Matrix2d foreshortened = Matrix2d::Identity() - n.head<2>() * n.head<2>().transpose();
    r.covariance =
        seen_[m.seen].covariance + settings_.pattern_sd_rad * settings_.pattern_sd_rad * foreshortened;
    r.design << 0.0, scale * n.z(), -scale * n.y(), 1.0, 0.0, n.x(), -scale * n.z(), 0.0, scale * n.x(), 0.0,
        1.0, n.y();
    return r;
  }

  double squared(const Match& m) const {
    const Row r = row(m);
    return r.residual.dot(r.covariance.inverse() * r.residual);
  }

  double reduced() const {
    double sum = 0.0;
    for (const Match& m : matches_) sum += squared(m);
    return sum / std::max(1.0, 2.0 * static_cast<double>(matches_.size()) - 3.0);
  }

  bool improve() {
    Vector6d prior;
    const double c = 1.0 / (settings_.centre_sd * settings_.centre_sd),
                 s = 1.0 / (settings_.radius_sd * settings_.radius_sd);
    prior << 0.0, 0.0, 0.0, c, c, s;
    Vector6d now;
    now << Vector3d::Zero(), centre_, relative_;
    Matrix6d normal = prior.asDiagonal();
    Vector6d right = -prior.cwiseProduct(now);
    for (const Match& m : matches_) {
      const Row r = row(m);
      const Eigen::Matrix<double, 6, 2> weighted = r.design.transpose() * r.covariance.inverse();
      normal += weighted * r.design;
      right += weighted * r.residual;
    }
    const Eigen::LDLT<Matrix6d> solver(normal);
    if (solver.info() != Eigen::Success || !solver.isPositive()) return false;
    const Vector6d change = solver.solve(right);
    if (!change.allFinite()) return false;
    attitude_ = attitude::rotation(change.head<3>()) * attitude_;
    centre_ += change.segment<2>(3);
    relative_ += change[5];
    covariance_ = solver.solve(Matrix6d::Identity()).topLeftCorner<3, 3>();
    return true;
  }

  BallAttitude result() const {
    BallAttitude found;
    found.attitude = attitude_;
    found.covariance_rad2 = std::max(1.0, reduced()) * covariance_;
    found.seen = static_cast<int>(seen_.size());
    found.matched = static_cast<int>(matches_.size());
    found.centre_off = centre_;
    for (const Match& m : matches_) found.rms_rad += row(m).residual.squaredNorm() / (2.0 * found.matched);
    found.rms_rad = std::sqrt(found.rms_rad);
    return found;
  }

  const std::vector<SeenDot>& seen_;
  const DotPattern& pattern_;
  DotMatchSettings settings_;
  std::vector<Match> matches_;
  Matrix3d attitude_;
  Vector2d centre_ = Vector2d::Zero();
  double relative_ = 0.0;
  Matrix3d covariance_ = Matrix3d::Zero();
};

}  // namespace

Result<BallAttitude> match_dots(const std::vector<SeenDot>& seen, const DotPattern& pattern,
                                const DotMatchSettings& settings) {
  const double sd = std::hypot(settings.pattern_sd_rad, settings.centre_sd, kFinestSd);
  const auto best = distinct(hypotheses(seen, pattern), seen, pattern, sd);
  const auto few = [&](std::size_t matched) {
    return fail(fmt::format("{} dark spots, of which {} lie as the pattern's dots; {} are needed",
                            seen.size(), matched, kMinMatched));
  };
  if (best.empty() || std::ssize(best.front().matches) < kMinMatched)
    return few(best.empty() ? 0 : best.front().matches.size());
  if (3 * best.front().matches.size() < 2 * seen.size())
    return fail(fmt::format("only {} of {} dark spots lie as the pattern's dots: is it this ball?",
                            best.front().matches.size(), seen.size()));
  if (best.size() > 1 && best[0].score - best[1].score < kThousandToOne)
    return fail(fmt::format("another attitude, {:.0f} degrees off, is as likely as one in {:.0f}",
                            angle_between(best[0].attitude, best[1].attitude) * 180.0 / std::numbers::pi,
                            1.0 + std::exp(best[0].score - best[1].score)));
  const auto fitted = AttitudeFit(seen, pattern, settings, best.front()).run();
  if (!fitted) return few(best.front().matches.size());
  return *fitted;
}

}  // namespace strobe::digitize
