// strobe fire --until-known: what the shots that count say after each of them, and whether that is enough.
// Single-threaded; some milliseconds a shot.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/config/rig_file.hpp"
#include "host/series/sequential.hpp"
#include "host/series/wanted.hpp"
#include "host/session/shot.hpp"

namespace strobe::host {

class UntilKnown {
 public:
  /// rig: of this run. earlier: the session's shots (series_shots()), oldest first.
  UntilKnown(std::vector<Wanted> wanted, std::shared_ptr<const RigFile> rig, std::vector<Shot> earlier);

  /// A shot that counts, with its messages; of an earlier run, too, whose result comes now.
  void add(const Shot& result);

  /// All that is wanted is known, by the shots of the newest one's condition.
  bool enough() const;
  /// Why no number of shots would be enough; empty: one would.
  std::string why_never() const;
  /// How well each is known: "e ± 0.0041 of 0.003 wanted; about 5 more shots".
  std::string line() const;

 private:
  void judge();

  std::vector<Wanted> wanted_;
  std::shared_ptr<const RigFile> rig_;
  std::vector<Shot> shots_;  ///< that count
  std::vector<Known> known_;
};

}  // namespace strobe::host
