// Protocols are written by people, and formulas in them: any bytes are either a protocol that can be explained and that
// shots can be evaluated by, or an error of one line that names the file. The bytes are a formula, too.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "host/protocol/evaluation.hpp"
#include "host/protocol/evaluation_text.hpp"
#include "tests/fuzz/require.hpp"

using namespace strobe::fuzz;

namespace {

/// Two shots of a ball with all numbers, and what the protocol asks to be noted.
std::vector<strobe::host::Shot> some_shots(const strobe::protocol::Protocol& protocol) {
  using namespace strobe::reduction;
  std::vector<strobe::host::Shot> shots(2);
  for (std::size_t s = 0; s < shots.size(); ++s) {
    shots[s].name = std::to_string(s + 1);
    shots[s].readout.record["protocol.position"] = protocol.positions.front();
    shots[s].readout.record["ball_name"] = "1";
    for (const strobe::protocol::Input& input : protocol.inputs)
      if (std::isfinite(input.allowed.low)) shots[s].readout.record[input.name] = std::to_string(input.allowed.low);
    BudgetSource scale{.source = Source::scale};
    for (std::size_t q = 0; q < kQuantityCount; ++q) {
      shots[s].readout.value[static_cast<Quantity>(q)] = 0.3 * static_cast<double>(q) - 1.0 + 0.1 * static_cast<double>(s);
      shots[s].budget.own_covariance[q][q] = scale.effect[q] = 0.01;
    }
    shots[s].budget.sources = {scale};
  }
  return shots;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace strobe::protocol;
  const std::string_view text = text_of(data, size);
  if (const auto formula = parse_formula(text); !formula) require(!formula.error().message.empty());
  const auto protocol = read_protocol(text, "fuzz.toml");
  if (!protocol) return require_one_line(protocol.error().message, "fuzz.toml"), 0;
  require(!explanation(*protocol).empty());
  // A thousand balls at a hundred places a thousand times are counted, not fired.
  if (protocol->balls * static_cast<int>(protocol->positions.size()) > 1000) return 0;
  const Evaluation evaluation = evaluate(*protocol, 1, some_shots(*protocol));
  for (const Value& value : evaluation.values)
    require(std::isfinite(value.value) && value.sd >= 0.0 && value.expanded >= 0.0);
  for (const Verdict& verdict : evaluation.verdicts)
    require(!verdict.risk || (*verdict.risk >= 0.0 && *verdict.risk <= 1.0));
  require(!strobe::protocol::text(*protocol, evaluation).empty());
  return 0;
}
