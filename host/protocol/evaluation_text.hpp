// A protocol and what became of it, in words for a person, a line each. Pure; thread-safe; allocates.
#pragma once

#include <string>
#include <vector>

#include "host/protocol/evaluation.hpp"
#include "host/protocol/protocol.hpp"

namespace strobe::protocol {

/// All that will happen and be decided, for who is to do it.
std::vector<std::string> explanation(const Protocol& protocol);

/// The verdict, the values with the largest parts of their uncertainty, and what is left to fire.
std::vector<std::string> text(const Protocol& protocol, const Evaluation& evaluation);

}  // namespace strobe::protocol
