// One shot of a scene without randomness: given draws and flashes, error-free digitizing, exact sensors.
// Plans measure scenes with it. Deterministic; thread-safe; allocates.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "common/reduction/frame.hpp"
#include "sim/motion/ball_path.hpp"
#include "sim/plan/corners.hpp"
#include "sim/plan/flight_bounds.hpp"
#include "sim/scene/model.hpp"
#include "sim/shoot/shoot.hpp"

namespace strobe::sim {

/// One flash: its time since touchdown, and by how much its time in the frame is late.
struct NominalFlash {
  double time_s = 0.0;
  double stamp_late_s = 0.0;
};

/// A frame with the flash of each of its images.
struct NominalFrame {
  reduction::Frame frame;
  std::vector<std::size_t> flash;  ///< indices of the flashes that were given
};

/// How long the train of a shot runs before and after the mean ball's touchdown, as Shooter has it. [s]
struct Train {
  double period_s = 0.0;
  double before_s = 0.0;
  double after_s = 0.0;
};
Train train_of(const Scene& scene, const ShootSettings& settings);

/// A scene under one model, with what is prepared once.
struct ModelledScene {
  ModelledScene(const Scene& scene, const Model& model);

  Scene whole;
  Scene left;  ///< with the model's effects only
  Model model;
  std::optional<ReducedContact> reduced;
};

/// The ball of one corner under one model, and the camera that sees it. The scene must outlive it.
class NominalShot {
 public:
  /// Returns nullopt if the contact's mechanics reject the conditions.
  static std::optional<NominalShot> make(const ModelledScene& scene, const Corner& corner);

  NominalFrame photograph(std::span<const NominalFlash> flashes) const;

  /// All flashes of the train that find the ball near the view, the first one after touchdown at phase (0…1)
  /// of a period; the ball meets the plate `late_s` after the mean one.
  std::vector<NominalFlash> flashes(const Train& train, double phase, double late_s) const;

  /// When flattening begins to be seen (incoming) and when it was last seen (rebounding), of the top of the
  /// ball; both half way through the contact where it is never seen. Between touchdown and the first, and the
  /// second and lift-off, an image passes for one in the air.
  struct Seen {
    double from_s = 0.0;
    double to_s = 0.0;
  };
  Seen flattening_seen() const;

  LegMotion incoming() const;
  LegMotion rebound() const;
  double dwell_s() const { return path_.dwell_s(); }
  const BallPath& path() const { return path_; }

 private:
  NominalShot(const Scene& scene, BallPath path);
  double seen_until_s(double direction) const;

  const Scene& scene_;
  BallPath path_;
  double first_seen_s_;
  double last_seen_s_;
};

}  // namespace strobe::sim
