// Whether a formula can be computed where its protocol wants it: names, functions, levels. Part of reading a
// protocol, not of its interface. Pure; thread-safe; allocates.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/reduction/readout.hpp"
#include "common/result.hpp"
#include "host/protocol/expression.hpp"
#include "host/protocol/protocol.hpp"

namespace strobe::protocol {

std::optional<reduction::Quantity> quantity_of(std::string_view name);

/// Quantities, inputs and numbers that were computed before.
std::vector<std::string> known_names(const Protocol& protocol);
bool is_known(const Protocol& protocol, std::string_view name);

/// mean, sd, spread, count; min and max of one number, perhaps at a position.
bool is_aggregate(const Expression& call, const Protocol& protocol);
/// The position that an aggregate names; absent: all that there are.
std::optional<std::string> position_of(const Expression& aggregate);

/// Of what the names in it are, the finest.
Level finest_level(const Expression& expression, const Protocol& protocol);

/// The formula of a number of that level; `protocol` as it was read so far. Fails with what is wrong and at
/// which character.
Result<void> check_formula(const Formula& formula, Level level, const Protocol& protocol);

std::string_view name(Level level);

}  // namespace strobe::protocol
