// Fits one outline to its sectors (sector_fit.hpp): robust weighted least squares for centre, radius, ovality
// and blur. Deterministic; thread-safe; allocates.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <vector>

#include "host/digitize/core/types.hpp"
#include "host/digitize/outline/outline_sd.hpp"

namespace strobe::digitize {

// The ovality of the ball's images on one photograph, estimated from all of them: a lens that is not
// calibrated stretches them away from the photograph's middle by the square of the distance from there,
// pixels that are not square all alike. Where only a part of an outline is visible, ovality, radius and
// centre are nearly degenerate, and the others' ovality serves as a prior. Deterministic; thread-safe;
// allocates.

/// An outline's deviation cos·cos 2θ + sin·sin 2θ from a circle, over its radius, as it alone tells it.
struct OvalSample {
  cv::Point2d at;  ///< plane px
  cv::Vec2d oval;
  cv::Matx22d covariance;  ///< positive definite
};

/// Prior sd in every direction: pixels are nearly square. Resizing rounds the sides of a picture to whole px,
/// a thousandth of one of 500.
inline constexpr double kSquare_sd = 1e-3;

class OvalModel {
 public:
  cv::Vec2d at(cv::Point2d plane_px) const;
  /// Of an outline there; with what one outline differs by from all others.
  cv::Matx22d covariance(cv::Point2d plane_px) const;
  /// As all samples but this one show it: a prior for the outline of which it is. The scatter stays.
  OvalModel without(const OvalSample& sample) const;
  double scatter() const { return scatter_; }  ///< sd of each component of one outline about the others

 private:
  friend std::optional<OvalModel> fit_oval_model(std::span<const OvalSample>, cv::Point2d, double, double);
  /// A sample's part of the normal equations, and of their right-hand side.
  struct Pull {
    cv::Matx33d normal = cv::Matx33d::zeros();
    cv::Vec3d right;
  };
  cv::Matx23d terms(cv::Point2d plane_px) const;
  Pull pull(const OvalSample& sample, bool robust = true) const;
  void solve();

  cv::Point2d middle_;
  double reach_px_ = 1.0;
  Pull all_;  ///< the prior's, too
  cv::Vec3d unknowns_;
  cv::Matx33d unsure_;  ///< covariance of the unknowns
  double scatter_ = 0.0;
};

/// `middle`: of the photograph; `reach_px`: from there to its corners; `stretch_sd`: prior sd of the ovality
/// in a corner, away from the middle. Returns nullopt for fewer than 5 samples.
std::optional<OvalModel> fit_oval_model(std::span<const OvalSample> samples, cv::Point2d middle,
                                        double reach_px, double stretch_sd);

struct OutlineFitSettings {
  int steps = 4;            ///< Gauss-Newton steps
  int coarse_steps = 2;     ///< the first of these, from a start that may be off by more than a px
  int further_steps = 0;    ///< at most so many more where half an outline is seen and still moves
  double sectors_px = 8.0;  ///< length of a sector
  double rays_px = 1.0;     ///< distance of the rays along which intensity is sampled
  /// How far out and in the profile is sampled, beyond three sd of the blur.
  double outside_px = 4.0, inside_px = 6.0;
  cv::Vec2d oval;  ///< prior ovality, cos and sin over the radius
  cv::Matx22d oval_covariance{2.5e-5, 0.0, 0.0, 2.5e-5};
  std::optional<double> radius_px, radius_sd_px;  ///< prior radius
};

struct FittedOutline {
  OutlineShape shape;
  double sigma_px = 1.0;     ///< sd of the blur
  OutlineMatrix covariance;  ///< symmetric, positive semi-definite
  /// Of the radius, what all outlines of a photograph are off alike: in the covariance, too.
  double shared_radius_sd_px = 0.0;
  std::vector<Arc> visible_arcs;    ///< sectors with a weight
  double visible_fraction = 0.0;    ///< of the outline
  double saturated_fraction = 0.0;  ///< of the outline
  double outside_fraction = 0.0;    ///< of the outline, beyond the photograph's border
  double rms_px = 0.0;              ///< of the weighted residuals
};

/// `sigma_px`: first guess of the blur. Returns nullopt if too few sectors have an edge.
std::optional<FittedOutline> fit_outline(const Photograph& photograph, const LocalFrame& frame,
                                         const OutlineShape& start, double sigma_px,
                                         std::span<const OutlineShape> neighbours,
                                         const OutlineFitSettings& settings);

/// Replaces the prior of an outline's ovality, fitted with the covariance `former` around none, by a better
/// one (Kalman update): `oval` over the radius with `covariance`, less than `former` in every direction.
/// Leaves an outline whose ovality contradicts it unchanged.
void apply_oval_prior(FittedOutline& fitted, cv::Vec2d oval, const cv::Matx22d& covariance,
                      const cv::Matx22d& former);

}  // namespace strobe::digitize
