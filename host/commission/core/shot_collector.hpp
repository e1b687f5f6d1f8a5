// Collects the sound shots that a step asks for, and asks again for those that were not: of a machine that was too late, or
// that lost edges, nothing can be said of the rig. Single-threaded; allocates.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "host/commission/core/step.hpp"

namespace strobe::commission {

class ShotCollector {
 public:
  static constexpr int kRetries = 8;  ///< in all

  ShotCollector() = default;
  /// One shot for each request, in their order.
  explicit ShotCollector(std::vector<Fire> wanted) : wanted_(std::move(wanted)) {}

  /// The next shot to ask for; absent: all are here, or there will be no more (problem()).
  const Fire* next() const;
  void add(FiredShot shot);
  /// No further shot.
  void give_up(std::string why) { problem_ = std::move(why); }

  /// Sound shots, in the order of the requests.
  const std::vector<FiredShot>& shots() const { return shots_; }
  int repeated() const { return repeated_; }
  /// Why not all are here; empty: they are, or are still to come.
  const std::string& problem() const { return problem_; }

 private:
  std::vector<Fire> wanted_;
  std::vector<FiredShot> shots_;
  int repeated_ = 0;
  std::string problem_;
};

/// Why nothing can be said of the rig by this shot; empty: it is sound.
std::string why_unsound(const FiredShot& shot);

}  // namespace strobe::commission
