// Formulas of a protocol: arithmetic, a documented set of functions, and numbers with their uncertainty
// through all of it. Pure; thread-safe; allocates.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "common/result.hpp"

namespace strobe::protocol {

struct Expression;

/// "100*(1 - mu) + 150*(0.81 - e_T)", "mean(cpr)", "100*mean(e, sample)/mean(e, concrete)",
/// "rise(vy_lo_mps)".
struct Formula {
  std::string text;
  std::shared_ptr<const Expression> expression;
};

/// Fails with what is wrong and at which character.
Result<Formula> parse_formula(std::string_view text);

}  // namespace strobe::protocol
