#include "host/camera/board_fit.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <opencv2/calib3d.hpp>

namespace strobe::camera {
namespace {

using digitize::LensDistortion;

constexpr int kPerView = 8;
constexpr int kTerms = static_cast<int>(kLensPriorSds.size());

struct Point {
  std::size_t view = 0;
  cv::Point2d board_m;
  cv::Point2d seen;  ///< normalized
  bool used = true;
};

struct Problem {
  std::vector<Point> points;
  std::size_t views = 0;
  double noise = 0.0;  ///< sd of a coordinate, normalized: what the priors are weighed against

  int parameters() const { return static_cast<int>(views) * kPerView + kTerms; }
  int used() const {
    return static_cast<int>(
        std::count_if(points.begin(), points.end(), [](const Point& p) { return p.used; }));
  }
};

/// A residual's two rows and its slopes.
void equations(const Problem& problem, const double* x, const Point& point, cv::Vec2d& residual,
               double* slope_x, double* slope_y) {
  const double* h = x + point.view * kPerView;
  const double* lens = x + problem.views * kPerView;
  const double bx = point.board_m.x, by = point.board_m.y;
  const double w = 1.0 / (h[6] * bx + h[7] * by + 1.0);
  const double u = (h[0] * bx + h[1] * by + h[2]) * w, v = (h[3] * bx + h[4] * by + h[5]) * w;
  const double k1 = lens[0], k2 = lens[1], p1 = lens[2], p2 = lens[3];
  const double r2 = u * u + v * v, radial = 1.0 + r2 * (k1 + r2 * k2), rise = 2.0 * (k1 + 2.0 * k2 * r2);
  residual = {u * radial + 2.0 * p1 * u * v + p2 * (r2 + 2.0 * u * u) - point.seen.x,
              v * radial + p1 * (r2 + 2.0 * v * v) + 2.0 * p2 * u * v - point.seen.y};
  if (!slope_x) return;
  const double xu = radial + rise * u * u + 2.0 * p1 * v + 6.0 * p2 * u;
  const double xv = rise * u * v + 2.0 * p1 * u + 2.0 * p2 * v;
  const double yv = radial + rise * v * v + 6.0 * p1 * v + 2.0 * p2 * u;
  const double to_u[kPerView] = {bx * w, by * w, w, 0.0, 0.0, 0.0, -u * bx * w, -u * by * w};
  const double to_v[kPerView] = {0.0, 0.0, 0.0, bx * w, by * w, w, -v * bx * w, -v * by * w};
  for (std::size_t i = 0; i < kPerView; ++i) {
    slope_x[point.view * kPerView + i] = xu * to_u[i] + xv * to_v[i];
    slope_y[point.view * kPerView + i] = xv * to_u[i] + yv * to_v[i];
  }
  const double along[4] = {u * r2, u * r2 * r2, 2.0 * u * v, r2 + 2.0 * u * u};
  const double down[4] = {v * r2, v * r2 * r2, r2 + 2.0 * v * v, 2.0 * u * v};
  for (int i = 0; i < kTerms; ++i) {
    slope_x[problem.views * kPerView + static_cast<std::size_t>(i)] = along[i];
    slope_y[problem.views * kPerView + static_cast<std::size_t>(i)] = down[i];
  }
}

class Equations : public cv::LMSolver::Callback {
 public:
  explicit Equations(const Problem& problem) : problem_(problem) {}

  bool compute(cv::InputArray parameters, cv::OutputArray residuals, cv::OutputArray slopes) const override {
    const cv::Mat x = parameters.getMat();
    const int rows = 2 * problem_.used() + kTerms;
    residuals.create(rows, 1, CV_64F);
    cv::Mat r = residuals.getMat(), j;
    if (slopes.needed()) {
      slopes.create(rows, problem_.parameters(), CV_64F);
      j = slopes.getMat();
      j.setTo(0.0);
    }
    int row = 0;
    for (const Point& point : problem_.points) {
      if (!point.used) continue;
      cv::Vec2d residual;
      equations(problem_, x.ptr<double>(), point, residual, j.empty() ? nullptr : j.ptr<double>(row),
                j.empty() ? nullptr : j.ptr<double>(row + 1));
      r.at<double>(row++) = residual[0];
      r.at<double>(row++) = residual[1];
    }
    for (int i = 0; i < kTerms; ++i, ++row) {
      const int column = static_cast<int>(problem_.views) * kPerView + i;
      const double weight = problem_.noise / kLensPriorSds[static_cast<std::size_t>(i)];
      r.at<double>(row) = weight * x.at<double>(column);
      if (!j.empty()) j.at<double>(row, column) = weight;
    }
    return true;
  }

 private:
  const Problem& problem_;
};

/// Of the points alone.
double sum_of_squares(const Problem& problem, const cv::Mat& x) {
  cv::Mat residuals;
  Equations(problem).compute(x, residuals, cv::noArray());
  const cv::Mat points = residuals.rowRange(0, residuals.rows - kTerms);
  return points.dot(points);
}

struct Solution {
  cv::Mat x;
  double squares = 0.0;
};

/// The points' noise is that of the residuals, and the priors' weight hangs on it: solved in turns.
Solution solve(Problem& problem, const cv::Mat& homographies, double first_noise) {
  Solution solution;
  solution.x = cv::Mat::zeros(problem.parameters(), 1, CV_64F);
  homographies.copyTo(solution.x.rowRange(0, homographies.rows));
  problem.noise = first_noise;
  constexpr int kMaxSteps = 100, kMaxRounds = 6;
  const double freedom = std::max(1.0, 2.0 * problem.used() - problem.parameters());
  for (int round = 0; round < kMaxRounds; ++round) {
    const cv::Ptr<Equations> equations_of = cv::makePtr<Equations>(problem);
    cv::LMSolver::create(equations_of, kMaxSteps)->run(solution.x);
    solution.squares = sum_of_squares(problem, solution.x);
    const double before = problem.noise;
    problem.noise = std::sqrt(solution.squares / freedom);
    if (std::abs(problem.noise - before) < 0.01 * before) break;
  }
  return solution;
}

int leave_outliers_out(Problem& problem, const cv::Mat& x) {
  std::vector<double> sizes;
  for (const Point& point : problem.points) {
    cv::Vec2d r;
    equations(problem, x.ptr<double>(), point, r, nullptr, nullptr);
    sizes.push_back(cv::norm(r));
  }
  std::vector<double> sorted = sizes;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2),
                   sorted.end());
  // The median of a Rayleigh distribution is 1.177 sigma.
  const double limit = 5.0 * std::max(sorted[sorted.size() / 2] / 1.177, 1e-9);
  int left_out = 0;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    problem.points[i].used = sizes[i] <= limit;
    left_out += sizes[i] > limit ? 1 : 0;
  }
  return left_out;
}

Result<cv::Mat> first_homographies(std::span<const BoardView> views, const Problem& problem) {
  cv::Mat x = cv::Mat::zeros(static_cast<int>(views.size()) * kPerView, 1, CV_64F);
  for (std::size_t v = 0; v < views.size(); ++v) {
    std::vector<cv::Point2d> from, to;
    for (const Point& point : problem.points) {
      if (point.view != v) continue;
      from.push_back(point.board_m);
      to.push_back(point.seen);
    }
    if (from.size() < 9) return fail(views[v].name + ": less than 9 points of the board");
    const cv::Mat h = cv::findHomography(from, to);
    if (h.empty() || !(std::abs(h.at<double>(2, 2)) > 1e-12))
      return fail(views[v].name + ": the board's points are on one line");
    for (int i = 0; i < kPerView; ++i)
      x.at<double>(static_cast<int>(v) * kPerView + i) = h.at<double>(i / 3, i % 3) / h.at<double>(2, 2);
  }
  return x;
}

Problem problem_of(std::span<const BoardView> views, const LensDistortion& lens) {
  Problem problem;
  problem.views = views.size();
  for (std::size_t v = 0; v < views.size(); ++v) {
    for (std::size_t i = 0; i < views[v].board_m.size() && i < views[v].image_px.size(); ++i) {
      const cv::Point2d seen = (views[v].image_px[i] - lens.centre_px) * (1.0 / lens.focal_px);
      problem.points.push_back({v, views[v].board_m[i], seen, true});
    }
  }
  return problem;
}

void report_residuals(const Problem& problem, const Solution& solution, BoardFit& fit) {
  std::vector<double> squares(problem.views, 0.0);
  std::vector<int> counts(problem.views, 0);
  for (const Point& point : problem.points) {
    if (!point.used) continue;
    cv::Vec2d r;
    equations(problem, solution.x.ptr<double>(), point, r, nullptr, nullptr);
    squares[point.view] += r.dot(r);
    counts[point.view] += 2;
  }
  for (std::size_t v = 0; v < problem.views; ++v) {
    fit.view_rms_px.push_back(fit.lens.focal_px * std::sqrt(squares[v] / std::max(1, counts[v])));
  }
  const double n = 2.0 * problem.used();
  fit.rms_px = fit.lens.focal_px * std::sqrt(solution.squares / n);
  fit.sigma_px = fit.lens.focal_px * std::sqrt(solution.squares / std::max(1.0, n - problem.parameters()));
}

/// Told: the sd is at most half of what it was without the boards.
int told_terms(const BoardFit& fit) {
  const int first = static_cast<int>(fit.parameters.size()) - kTerms;
  int told = 0;
  for (int i = 0; i < kTerms; ++i) {
    const double sd = std::sqrt(std::max(0.0, fit.covariance.at<double>(first + i, first + i)));
    told += sd <= 0.5 * kLensPriorSds[static_cast<std::size_t>(i)] ? 1 : 0;
  }
  return told;
}

BoardFit finish(const Problem& problem, const Solution& solution, const LensDistortion& lens, int outliers) {
  BoardFit fit;
  fit.lens = lens;
  fit.points = problem.used();
  fit.outliers = outliers;
  fit.parameters.assign(solution.x.ptr<double>(), solution.x.ptr<double>() + problem.parameters());
  report_residuals(problem, solution, fit);
  cv::Mat residuals, slopes, inverse;
  Equations(problem).compute(solution.x, residuals, slopes);
  cv::invert(slopes.t() * slopes, inverse, cv::DECOMP_SVD);
  fit.covariance = inverse * (problem.noise * problem.noise);
  fit.lens_terms = told_terms(fit);
  fit.lens = lens_of(fit, fit.parameters);
  for (std::size_t v = 0; v < problem.views; ++v)
    fit.homographies.push_back(homography_of(fit.parameters, v));
  return fit;
}

Result<BoardFit> fit_all(std::span<const BoardView> views, int width_px, int height_px) {
  LensDistortion lens;
  lens.centre_px = {0.5 * (width_px - 1), 0.5 * (height_px - 1)};
  lens.focal_px = std::hypot(width_px, height_px);
  Problem problem = problem_of(views, lens);
  const auto start = first_homographies(views, problem);
  if (!start) return tl::unexpected(start.error());
  // A tenth of a pixel: what corners are found to on a plain photograph.
  Solution solution = solve(problem, *start, 0.1 / lens.focal_px);
  const int outliers = leave_outliers_out(problem, solution.x);
  if (outliers > 0) solution = solve(problem, *start, problem.noise);
  if (!std::isfinite(solution.squares)) return fail("the boards' points fit no camera");
  return finish(problem, solution, lens, outliers);
}

/// Of a view that is not taken yet.
struct PlannedInformation {
  cv::Mat homography_covariance;  ///< the lens being known
  cv::Mat homography_by_lens;     ///< how its homography follows the lens' terms
  cv::Mat of_lens;                ///< the information that it adds
};

PlannedInformation planned_information(const BoardFit& fit, std::span<const cv::Point2d> board_m,
                                       const cv::Matx33d& homography) {
  Problem problem;  // without noise the priors weigh nothing: the fit has them
  problem.views = 1;
  for (const cv::Point2d& p : board_m) problem.points.push_back({0, p, {}, true});
  cv::Mat x(problem.parameters(), 1, CV_64F), residuals, slopes;
  for (int i = 0; i < kPerView; ++i) x.at<double>(i) = homography.val[i] / homography.val[kPerView];
  std::copy(fit.parameters.end() - kTerms, fit.parameters.end(), x.ptr<double>(kPerView));
  Equations(problem).compute(x, residuals, slopes);
  slopes *= fit.lens.focal_px / std::max(fit.sigma_px, 1e-9);
  const cv::Mat own = slopes.colRange(0, kPerView), lens = slopes.colRange(kPerView, kPerView + kTerms);
  PlannedInformation planned;
  cv::invert(own.t() * own, planned.homography_covariance, cv::DECOMP_CHOLESKY);
  planned.homography_by_lens = -planned.homography_covariance * (own.t() * lens);
  planned.of_lens = lens.t() * lens + lens.t() * own * planned.homography_by_lens;
  return planned;
}

/// The covariance once the lens' terms are told of by so much more information (Woodbury's identity).
cv::Mat informed(const cv::Mat& covariance, const cv::Mat& of_lens) {
  const int n = covariance.rows;
  const cv::Mat with_lens = covariance.colRange(n - kTerms, n);
  const cv::Mat gain = cv::Mat::eye(kTerms, kTerms, CV_64F) + with_lens.rowRange(n - kTerms, n) * of_lens;
  return covariance - with_lens * of_lens * gain.inv() * with_lens.t();
}

}  // namespace

LensDistortion lens_of(const BoardFit& fit, std::span<const double> parameters) {
  LensDistortion lens = fit.lens;
  const std::span<const double> terms = parameters.last(kLensPriorSds.size());
  lens.k1 = terms[0];
  lens.k2 = terms[1];
  lens.p1 = terms[2];
  lens.p2 = terms[3];
  return lens;
}

cv::Matx33d homography_of(std::span<const double> parameters, std::size_t view) {
  const auto h = parameters.subspan(view * kPerView, kPerView);
  return {h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], 1.0};
}

Result<BoardFit> fit_boards(std::span<const BoardView> views, int width_px, int height_px) {
  if (views.empty()) return fail("no photograph of a board");
  try {
    return fit_all(views, width_px, height_px);
  } catch (const cv::Exception& error) {
    return fail("the fit of the boards failed: " + error.err);
  }
}

cv::Mat covariance_with(const BoardFit& fit, std::span<const cv::Point2d> board_m,
                        const cv::Matx33d& homography) {
  return informed(fit.covariance, planned_information(fit, board_m, homography).of_lens);
}

BoardFit with_planned_view(const BoardFit& fit, std::span<const cv::Point2d> board_m,
                           const cv::Matx33d& homography) {
  const PlannedInformation planned = planned_information(fit, board_m, homography);
  const int before = fit.covariance.rows, views = before - kTerms;
  // The parameters so far, with the new homography, as it follows the lens, ahead of the lens' terms.
  cv::Mat follow = cv::Mat::zeros(before + kPerView, before, CV_64F);
  cv::setIdentity(follow(cv::Rect(0, 0, views, views)));
  planned.homography_by_lens.copyTo(follow(cv::Rect(views, views, kTerms, kPerView)));
  cv::setIdentity(follow(cv::Rect(views, views + kPerView, kTerms, kTerms)));
  BoardFit more = fit;
  more.covariance = follow * informed(fit.covariance, planned.of_lens) * follow.t();
  more.covariance(cv::Rect(views, views, kPerView, kPerView)) += planned.homography_covariance;
  const cv::Matx33d h = homography * (1.0 / homography(2, 2));
  more.homographies.push_back(h);
  more.parameters.insert(more.parameters.end() - kTerms, h.val, h.val + kPerView);
  return more;
}

}  // namespace strobe::camera
