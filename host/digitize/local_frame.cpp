#include "host/digitize/local_frame.hpp"

#include <cmath>

namespace strobe::digitize {

namespace {

std::array<double, 10> monomials(double u, double v) {
  return {1.0, u, v, u * u, u * v, v * v, u * u * u, u * u * v, u * v * v, v * v * v};
}

double dot(const std::array<double, 10>& a, const std::array<double, 10>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

}  // namespace

LocalFrame::LocalFrame(const PlaneMap& map, cv::Point2d centre_image, double reach_px)
    : plain_(map.is_plain()),
      centre_image_(centre_image),
      origin_(map.to_plane(centre_image)),
      reach_px_(reach_px) {
  if (plain_) return;
  const cv::Matx22d d = map.derivative(centre_image);
  scale_ = 1.0 / std::sqrt(std::abs(d(0, 0) * d(1, 1) - d(0, 1) * d(1, 0)));
  to_image_ = (d * scale_).inv();
  constexpr int kSide = 7;
  cv::Matx<double, kTerms, kTerms> normal = cv::Matx<double, kTerms, kTerms>::zeros();
  cv::Matx<double, kTerms, 2> right = cv::Matx<double, kTerms, 2>::zeros();
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      const double u = 2.0 * i / (kSide - 1) - 1.0, v = 2.0 * j / (kSide - 1) - 1.0;
      const cv::Point2d at = from_plane(map.to_plane(centre_image + reach_px * cv::Point2d(u, v)));
      const auto terms = monomials(u, v);
      for (int a = 0; a < kTerms; ++a) {
        const double term = terms[static_cast<std::size_t>(a)];
        for (int b = 0; b < kTerms; ++b) normal(a, b) += term * terms[static_cast<std::size_t>(b)];
        right(a, 0) += term * at.x;
        right(a, 1) += term * at.y;
      }
    }
  }
  const cv::Matx<double, kTerms, 2> solution = normal.solve(right, cv::DECOMP_CHOLESKY);
  for (int a = 0; a < kTerms; ++a) {
    x_[static_cast<std::size_t>(a)] = solution(a, 0);
    y_[static_cast<std::size_t>(a)] = solution(a, 1);
  }
}

cv::Point2d LocalFrame::to_image(cv::Point2d local_px) const {
  const cv::Vec2d d = to_image_ * cv::Vec2d(local_px.x, local_px.y);
  return {centre_image_.x + d[0], centre_image_.y + d[1]};
}

cv::Point2d LocalFrame::from_image(double column, double row) const {
  const double du = column - centre_image_.x, dv = row - centre_image_.y;
  if (plain_) return {du, -dv};
  const auto terms = monomials(du / reach_px_, dv / reach_px_);
  return {dot(x_, terms), dot(y_, terms)};
}

}  // namespace strobe::digitize
