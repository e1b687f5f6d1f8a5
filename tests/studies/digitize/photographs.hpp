// Rendered photographs of simulated shots as the digitizer and the score need them. Deterministic;
// thread-safe; allocates.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "common/result.hpp"
#include "host/digitize/digitize.hpp"
#include "host/digitize/image/photograph.hpp"
#include "sim/photograph/lit_balls.hpp"
#include "sim/scene/scene.hpp"
#include "sim/shoot/shoot.hpp"
#include "tests/studies/digitize/distractors.hpp"
#include "tests/studies/digitize/independent_render.hpp"
#include "tests/studies/digitize/score.hpp"

namespace strobe::studies::digitize {

/// Which photograph: of the scene's `shot`-th shot (1-based).
struct Take {
  sim::Scene scene;
  std::uint64_t seed = 1;
  int shot = 1;
  /// Empty, or a folder of photographs: one rendered there before is read instead of rendered again, whatever
  /// has become of the renderer since; a new one is left there.
  std::filesystem::path kept_in{};
  bool independent = false;  ///< the second renderer's
  IndependentLook look{};
  std::optional<int>
      jpeg_quality{};  ///< 1 to 100, 8 bits; 0: not compressed; absent: 85 to 95 of the second renderer's
  bool ignore_marking = false;    ///< a line is looked for on a ball that has none, too
  sim::ShootSettings shooting{};  ///< a kept photograph is one of the same train of flashes
  Distractors distractors{};      ///< added to what was rendered or kept
};

struct KnownPhotograph {
  strobe::digitize::Photograph photograph;  ///< read as from an uncompressed TIFF
  strobe::digitize::DigitizeSettings settings;
  std::vector<TrueImage> truth;
  std::vector<TrueImage> others;               ///< of second balls
  std::vector<double> times_s;                 ///< of the true images, in the same order
  std::vector<reduction::PointPx> surface_px;  ///< two points of the surface's true line
  /// Foot of the lens on the plane of flight, and its distance, px; absent: infinitely far.
  std::optional<std::array<double, 3>> viewpoint_px{};
  double decode_ms = 0.0;
  sim::SimulatedShot shot;
  sim::PhotographTruth scene_truth;
};

/// Fails as Shooter, render() and decode_photograph() do, or if a file cannot be written.
Result<KnownPhotograph> known_photograph(const Take& take);

/// The same without its photograph. Fails as Shooter does.
Result<KnownPhotograph> known_exposure(const Take& take);

/// The bytes of an uncompressed TIFF, as the rig's camera writes it; the second renderer's of a JPEG.
Result<std::vector<unsigned char>> photograph_bytes(const Take& take, const sim::SimulatedShot& shot);

}  // namespace strobe::studies::digitize
