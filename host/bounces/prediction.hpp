// A published bounce as the impact models predict it: nothing in them is fitted to it. The input is its
// motion at touchdown, its own restitution (0.75 where that is not published) and a coefficient of friction
// that the data set names. Residuals carry the uncertainty of all numbers that enter them. Pure; thread-safe;
// copies names.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "common/data/published_bounces.hpp"
#include "common/impact/closed_form/rebound.hpp"
#include "common/impact/fit/rolling_friction.hpp"

namespace strobe::bounces {

enum class Model {
  /// Rigid body that slides or rolls off; a tennis ball as a thin shell (Brody), a solid one with its own
  /// alpha.
  rigid,
  /// Closed form with tangential restitution and an offset normal force, fitted to the thesis's 21
  /// conditions; alpha
  /// of the ball.
  grip,
  /// The contact mechanics as fitted to the same conditions, alpha of that fit (of a solid ball: its own).
  mechanics,
  /// The contact mechanics with what is known of this ball and this experiment: its alpha, the weight along
  /// an inclined
  /// surface (in the friction that a bounce tells, too), the friction measured elsewhere. A solid ball: k_t/k
  /// of its Poisson's ratio (Mindlin), dashpots of one material (c_t/k_t = c/k), no offset. On turf: the
  /// rigid body on a contact plane that tilts (impact::contact_plane_tilt_rad).
  known,
  /// Stiff elastic ball (impact::elastic_rebound) of its Poisson's ratio; of a shell that of its rubber.
  elastic,
};
inline constexpr std::array kModels{Model::rigid, Model::grip, Model::mechanics, Model::known,
                                    Model::elastic};

constexpr std::string_view name(Model model) {
  constexpr std::array<std::string_view, 5> names{"rigid", "grip", "mechanics", "known", "elastic"};
  return names[static_cast<std::size_t>(model)];
}

/// Dwell time that the mechanics are computed with, and how well it is known. It matters for the weight
/// alone.
inline constexpr double kDwell_s = 5e-3;
inline constexpr double kDwellSd_s = 1e-3;

/// One bounce with all that a prediction of it uses.
struct Case {
  published::Ball ball;
  published::Bounce bounce;
  published::Friction friction;
  std::optional<published::Bounce> friction_row{};  ///< another bounce that tells the friction
  double dwell_s = kDwell_s;

  /// Of the bounce that tells it, or as given.
  double mu() const;
  /// Whether this bounce's own change of vx gives the friction.
  bool tells_its_own_friction() const { return friction.row == bounce.name; }
};

/// The cases of a set, in its order. Precondition: the set is of `all`, as load_bounces() returned it.
std::vector<Case> cases_of(const published::Bounces& all, const published::Set& set);

/// Predicted less measured, with the sd of that difference.
struct Residual {
  std::optional<published::Measured> vx_mps{}, omega_radps{};  ///< absent: not published
};

struct Prediction {
  impact::Motion lift_off;
  Residual residual;
  double mu = 0.0;               ///< that it was computed with
  bool vx_is_given = false;      ///< mu is this bounce's own impulse ratio: its vx is no prediction
  std::string_view not_valid{};  ///< as not_valid() says
};

/// Fails with the bounce's name and what the model refuses.
Result<Prediction> predict(const Case& bounce, Model model);

/// Why the model has no claim to this bounce; empty: it has. Rigid, grip and mechanics do not know ground
/// that yields; the constants of grip and mechanics are a tennis ball's on a hard surface; the elastic ball
/// is solid, on a surface that is hard.
std::string_view not_valid(const Case& bounce, Model model);

/// Acceleration of gravity along the surface in the direction of +x and into it; 0 where the incline is not
/// published.
struct Weight {
  double along_mps2 = 0.0;
  double into_mps2 = 0.0;
};
Weight weight_of(const published::Bounce& bounce);

// What a published bounce says of angular momentum about the contact point, whatever the friction was and
// whether the ball gripped:
//   alpha·R·(omega_LO - omega_TD) = (vx_LO - vx_TD) - g_x·dwell + d·J/R,
// with g_x the weight's acceleration along the surface and d the normal force's offset ahead of the centre.
// Either alpha follows, if there is no offset, or the offset, with the ball's alpha. Pure; thread-safe;
// copies names.

struct Balance {
  published::Measured alpha;       ///< without an offset
  published::Measured offset_m;    ///< with the ball's alpha; sd statistical
  double offset_sd_alpha_m = 0.0;  ///< systematic, from the ball's alpha
  double slip_lo_mps = 0.0;        ///< vx + R·omega at lift-off
  double e_x = 0.0;                ///< -slip_LO/slip_TD; negative where the ball slides to the end
};

/// With the weight along the surface taken off, or without. nullopt where a velocity or the spin at lift-off
/// is not published, or where the spin did not change.
std::optional<Balance> balance_of(const Case& bounce, bool with_weight);

/// One alpha for all, weighted by the statistical sds; chi-square of its residuals.
struct MeanAlpha {
  published::Measured alpha;
  double chi_square = 0.0;
  int count = 0;
};

/// Precondition: sds above 0.
MeanAlpha mean_of(std::span<const published::Measured> alphas);

}  // namespace strobe::bounces
