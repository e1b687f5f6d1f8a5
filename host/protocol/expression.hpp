// A parsed formula. Part of the protocol's formulas, not of their interface.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace strobe::protocol {

struct Expression {
  enum class Kind { number, name, text, negate, add, subtract, multiply, divide, power, call };

  Kind kind = Kind::number;
  double number = 0.0;
  std::string name{};                   ///< of Kind::name, text and call
  std::vector<Expression> arguments{};  ///< one of negate, two of the other operators
  std::size_t at = 0;                   ///< character in the formula, from 1
};

}  // namespace strobe::protocol
