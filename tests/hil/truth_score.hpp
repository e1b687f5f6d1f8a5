// How far readouts are from the truth, in units of the sd that they state themselves. Values only.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace strobe::hil {

/// Shots whose numbers are not valid say so by their flags: they are not judged, but they are
/// counted.
bool is_rejected(const nlohmann::json& readout);

/// Whether every quantity that a rebound always has (all but the court pace) is a number.
bool is_complete(const nlohmann::json& readout);

class TruthScore {
 public:
  /// Errors in units of the stated sd. A number without an sd, or an sd that is not positive, counts as
  /// infinitely wrong.
  void add(const nlohmann::json& readout, const nlohmann::json& truth, const std::string& name);

  /// Lines naming what is off by more than `limit` sd; empty if nothing is.
  std::string beyond(double limit) const;

  /// Lines naming the quantities whose rms over the shots is not what that many shots allow around 1: the sum
  /// of squares of n independent standard normal errors is chi-squared with n degrees of freedom; quantities
  /// of one shot depend on each other, shots do not. `false_alarm` is the chance that any quantity is named
  /// although all stated sds are true, shared out evenly over them and the two sides (Bonferroni).
  std::string implausible_rms(double false_alarm) const;

  /// Of one quantity's errors. Returns nullopt if there are none.
  std::optional<double> rms_of(const std::string& quantity) const;

  /// A table of rms and largest error by quantity.
  std::string table() const;

  std::size_t shots() const { return shots_; }

 private:
  struct Error {
    double z = 0.0;
    std::string shot;
  };
  std::map<std::string, std::vector<Error>> errors_;
  std::size_t shots_ = 0;
};

}  // namespace strobe::hil
