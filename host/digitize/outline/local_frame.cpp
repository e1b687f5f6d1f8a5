#include "host/digitize/outline/local_frame.hpp"

namespace strobe::digitize {

namespace {

constexpr int kTerms = 10;
using Monomials = std::array<double, kTerms>;

Monomials monomials(double u, double v) {
  return {1.0, u, v, u * u, u * v, v * v, u * u * u, u * u * v, u * v * v, v * v * v};
}

/// Fits cubics in (u, v) to points, by least squares.
class CubicFit {
 public:
  void add(double u, double v, cv::Point2d value) {
    const Monomials terms = monomials(u, v);
    for (int a = 0; a < kTerms; ++a) {
      const double term = terms[static_cast<std::size_t>(a)];
      for (int b = 0; b < kTerms; ++b) normal_(a, b) += term * terms[static_cast<std::size_t>(b)];
      right_(a, 0) += term * value.x;
      right_(a, 1) += term * value.y;
    }
  }
  void solve(Monomials& x, Monomials& y) const {
    const cv::Matx<double, kTerms, 2> solution = normal_.solve(right_, cv::DECOMP_CHOLESKY);
    for (int a = 0; a < kTerms; ++a) {
      x[static_cast<std::size_t>(a)] = solution(a, 0);
      y[static_cast<std::size_t>(a)] = solution(a, 1);
    }
  }

 private:
  cv::Matx<double, kTerms, kTerms> normal_ = cv::Matx<double, kTerms, kTerms>::zeros();
  cv::Matx<double, kTerms, 2> right_ = cv::Matx<double, kTerms, 2>::zeros();
};

}  // namespace

LocalFrame::LocalFrame(const PlaneMap& map, cv::Point2d centre_image, double reach_px)
    : uncalibrated_(map.is_uncalibrated()),
      centre_image_(centre_image),
      origin_(map.to_plane(centre_image)),
      scale_(map.image_px_per_plane_px(centre_image)),
      reach_px_(reach_px) {
  if (uncalibrated_) return;
  constexpr int kSide = 7;
  CubicFit fit;
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      const double u = 2.0 * i / (kSide - 1) - 1.0, v = 2.0 * j / (kSide - 1) - 1.0;
      fit.add(u, v, map.to_image(to_plane(reach_px * cv::Point2d(u, v))));
    }
  }
  fit.solve(column_, row_);
}

double LocalFrame::at(const Cubic& cubic, double u, double v) {
  const Monomials terms = monomials(u, v);
  double sum = 0.0;
  for (std::size_t i = 0; i < terms.size(); ++i) sum += cubic[i] * terms[i];
  return sum;
}

}  // namespace strobe::digitize
