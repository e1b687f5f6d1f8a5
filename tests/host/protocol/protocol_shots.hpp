// Shots for protocols, with budgets that tests can do sums with.
#pragma once

#include <fmt/format.h>

#include <string>
#include <vector>

#include "host/protocol/evaluation.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

namespace strobe::test {

/// Of position and ball, with e and mu. One sd of the scale is `by_scale` of e; of the shot's own noise `own`, of both.
struct ProtocolShot {
  std::string position = "1", ball = "1";
  double e = 0.8, mu = 0.5;
  double by_scale = 0.01, own = 0.0;
  double correlation = 0.0;  ///< of the own noise of e and mu
};

inline host::Shot protocol_shot(int number, const ProtocolShot& made) {
  using namespace reduction;
  constexpr auto kE = static_cast<std::size_t>(Quantity::e), kMu = static_cast<std::size_t>(Quantity::mu);
  host::Shot shot;
  shot.name = std::to_string(number);
  shot.calibration = "the camera's";
  shot.ball = "ball " + made.ball;
  shot.readout.record = {{"protocol.position", made.position}, {"ball_name", made.ball}};
  shot.readout.value[Quantity::e] = made.e;
  shot.readout.value[Quantity::mu] = made.mu;
  BudgetSource scale{.source = Source::scale, .input_sd = 1.0, .input_unit = "%"};
  scale.effect[kE] = made.by_scale;
  shot.budget.sources = {scale};
  shot.budget.own_covariance[kE][kE] = shot.budget.own_covariance[kMu][kMu] = made.own * made.own;
  shot.budget.own_covariance[kE][kMu] = shot.budget.own_covariance[kMu][kE] = made.correlation * made.own * made.own;
  return shot;
}

inline std::vector<host::Shot> protocol_shots(const std::vector<ProtocolShot>& made) {
  std::vector<host::Shot> shots;
  for (const ProtocolShot& one : made) shots.push_back(protocol_shot(static_cast<int>(shots.size()) + 1, one));
  return shots;
}

inline std::string computed(const std::string& name, const std::string& level, const std::string& formula) {
  return fmt::format("[[computed]]\nname = \"{}\"\nwords = \"{}\"\nlevel = \"{}\"\nformula = \"{}\"\n", name, name, level,
                     formula);
}

/// With `more` tables; test: lines of [test].
inline std::string protocol_text(const std::string& test, const std::string& more) {
  return "title = \"a test\"\n[source]\ndocument = \"a document\"\nread = \"whole\"\n[test]\n" + test +
         "\n[impact]\nkind = \"dropped\"\ndrop_height_m = 1.0\n" + more;
}

inline protocol::Protocol protocol_of(const std::string& test, const std::string& more) {
  auto read = protocol::read_protocol(protocol_text(test, more), "a.toml");
  if (!read) FAIL(read.error().message.c_str());
  return *std::move(read);
}

/// The value of that name, of that position if one is given.
inline const protocol::Value& value_of(const protocol::Evaluation& e, const std::string& name, const std::string& position = "") {
  for (const protocol::Value& value : e.values)
    if (value.name == name && (position.empty() || value.cell.position == position)) return value;
  FAIL(("no value " + name).c_str());
  return e.values.front();
}

}  // namespace strobe::test
