// The ovality of the ball's images on one photograph, estimated from all of them: uncalibrated perspective
// stretches them away from the photograph's middle by the square of the distance from there, pixels that are
// not square all alike. Where only a part of an outline is visible, ovality, radius and centre are nearly
// degenerate, and the others' ovality serves as a prior. Deterministic; thread-safe; allocates.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <span>

namespace strobe::digitize {

/// An outline's deviation cos·cos 2θ + sin·sin 2θ from a circle, over its radius.
struct OvalSample {
  cv::Point2d at;  ///< plane px
  cv::Vec2d oval;
  cv::Matx22d covariance;
};

class OvalModel {
 public:
  cv::Vec2d at(cv::Point2d plane_px) const;
  double sd() const { return sd_; }  ///< of each component for one outline

 private:
  friend std::optional<OvalModel> fit_oval_model(std::span<const OvalSample>, cv::Point2d, double);
  cv::Matx23d terms(cv::Point2d plane_px) const;

  cv::Point2d middle_;
  double reach_px_ = 1.0;
  cv::Vec3d unknowns_;
  double sd_ = 0.0;
};

/// `middle`: of the photograph; `reach_px`: from there to its corners. Returns nullopt for fewer than 5
/// samples.
std::optional<OvalModel> fit_oval_model(std::span<const OvalSample> samples, cv::Point2d middle,
                                        double reach_px);

}  // namespace strobe::digitize
