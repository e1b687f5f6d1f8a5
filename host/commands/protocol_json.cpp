#include "host/commands/protocol_json.hpp"

#include <array>
#include <nlohmann/json.hpp>

#include "common/messages/parsed_json.hpp"
#include "host/view/series_json.hpp"

namespace strobe::host {
namespace {

using messages::or_null;
using nlohmann::ordered_json;

ordered_json cell_json(const protocol::Cell& cell, const std::string& shot) {
  const auto or_none = [](const std::string& text) {
    return text.empty() ? ordered_json() : ordered_json(text);
  };
  return {{"position", or_none(cell.position)}, {"ball", or_none(cell.ball)}, {"shot", or_none(shot)}};
}

std::string_view name_of(protocol::Use use) {
  constexpr std::array<std::string_view, 5> kNames{"counts", "discarded", "not_conforming", "rejected",
                                                   "surplus"};
  return kNames[static_cast<std::size_t>(use)];
}

}  // namespace

nlohmann::ordered_json evaluation_json(const protocol::Protocol& protocol, const protocol::Evaluation& e) {
  ordered_json values = ordered_json::array(), verdicts = values, shots = values, left = values;
  for (const protocol::Value& v : e.values)
    values.push_back({{"name", v.name},
                      {"of", cell_json(v.cell, v.shot)},
                      {"value", v.value},
                      {"sd", v.sd},
                      {"degrees_of_freedom", or_null(v.degrees_of_freedom)},
                      {"expanded_uncertainty", v.expanded},
                      {"budget", budget_json(v.budget)}});
  for (const protocol::Verdict& v : e.verdicts)
    verdicts.push_back({{"requirement", v.requirement},
                        {"of", cell_json(v.cell, v.shot)},
                        {"outcome", name(v.outcome)},
                        {"category", v.category.empty() ? ordered_json() : ordered_json(v.category)},
                        {"risk", or_null(v.risk)},
                        {"why", v.why}});
  for (const protocol::UsedShot& s : e.shots)
    shots.push_back({{"of", cell_json(s.cell, s.shot)}, {"use", name_of(s.use)}, {"why", s.why}});
  for (const protocol::Block& b : e.blocks)
    left.push_back({{"of", cell_json(b.cell, "")}, {"shots", b.shots}, {"words", b.words}});
  return {{"protocol", protocol.name},
          {"outcome", name(e.outcome)},
          {"why", e.why},
          {"verdicts", verdicts},
          {"values", values},
          {"shots", shots},
          {"replaced", e.replaced},
          {"left", left}};
}

}  // namespace strobe::host
