// What a person wants to know how well, as typed: "e:0.003", "omega_lo:1%". Pure; thread-safe; allocates.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/reduction/readout.hpp"
#include "common/result.hpp"

namespace strobe::host {

/// Of one quantity: the half width of a 95 % interval, or the size of a difference.
struct Wanted {
  reduction::Quantity quantity = reduction::Quantity::e;
  double value = 0.0;        ///< > 0; in the quantity's unit, or in percent of it
  bool is_relative = false;  ///< in percent

  /// In the quantity's unit, where the quantity is `mean`.
  double size(double mean) const;
  bool operator==(const Wanted&) const = default;
};

enum class Percent { allowed, refused };

/// The quantity of that name, whose unit may be left out where no other begins likewise. Fails with the names
/// that there are.
Result<reduction::Quantity> find_quantity(const std::string& name);

/// One text each. option: named in complaints, as "--difference". default_quantity: of a number alone; empty:
/// there is none. Fails for an unknown quantity, for one that is named twice and for what is no number above
/// 0.
Result<std::vector<Wanted>> parse_wanted(std::string_view option, const std::vector<std::string>& texts,
                                         Percent percent, const std::string& default_quantity = "");

/// As typed, the quantity by its full name: "e:0.003,omega_lo_radps:1%".
std::string wanted_text(const std::vector<Wanted>& wanted);

}  // namespace strobe::host
