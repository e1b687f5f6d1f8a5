// A test protocol as its file says it: what is thrown or dropped, how often and at what, which impacts
// conform, what is computed from them, and how that is decided. Plain values and pure functions but for
// load_protocol(), which reads a file; thread-safe. Sources of the decision: JCGM 106:2012; ILAC-G8:09/2019.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"
#include "host/protocol/decision.hpp"
#include "host/protocol/formula.hpp"

namespace strobe::protocol {

enum class ImpactKind { thrown, dropped };

/// Whether the people who wrote the file have read the document that it follows.
enum class SourceRead {
  whole,     ///< the document itself
  summary,   ///< numbers as others state them, named in `where`
  not_read,  ///< no verdict is given
};

struct ProtocolSource {
  std::string document;  ///< "ITF CS 01/02"
  std::string edition;   ///< "2019"
  SourceRead read = SourceRead::not_read;
  std::string where;  ///< where its numbers were read
};

/// What the impacts are to be; a plan and a scene are made for it.
struct NominalImpact {
  ImpactKind kind = ImpactKind::thrown;
  double speed_mps = 0.0;      ///< thrown: at touchdown
  double angle_deg = 0.0;      ///< thrown: of the path to the surface, > 0
  double spin_radps = 0.0;     ///< thrown
  double drop_height_m = 0.0;  ///< dropped: of the ball's lowest point above the surface
};

/// What a shot must be to count. Quantities by their readout names (theta_in_deg, v_td_mps, omega_td_radps
/// ...), or an input's name.
struct Conformance {
  std::string quantity;
  Interval allowed;
};

/// A number that a person states for the whole test or, if `varies`, for each shot (temperature_c ...): taken
/// from the shots' notes, or from `value` where the protocol fixes it.
struct Input {
  std::string name;
  std::string unit{};
  std::string words{};            ///< asked of the operator
  double sd = 0.0;                ///< of its error, which all shots share
  std::optional<double> value{};  ///< absent: must be noted
  Interval allowed{};
};

/// Over what a computed number is.
enum class Level {
  shot,      ///< each shot that conforms
  ball,      ///< each ball at each position
  position,  ///< each position
  test,      ///< all
};

struct Computed {
  std::string name;
  std::string words{};  ///< for a person
  std::string unit{};
  Level level = Level::shot;
  Formula formula{};  ///< of quantities, inputs and what was computed before; see formula.hpp
};

struct Category {
  std::string name;
  Interval range;
};

struct Requirement {
  std::string name;  ///< of the computed number; each of its ball's or position's must meet it
  std::string clause{};
  Interval limits{};                   ///< ignored with categories
  std::vector<Category> categories{};  ///< classified instead of passed; ascending
  DecisionRule rule = DecisionRule::guarded;
  double risk = 0.05;
};

struct Protocol {
  std::string name;  ///< the file's, without ending
  std::string title;
  ProtocolSource source;
  std::string ball_kind;  ///< of common/data/balls, empty: any
  int balls = 1;
  std::vector<std::string> positions{"1"};  ///< names; "concrete", "sample" ...
  int repeats = 1;                          ///< shots that conform of each ball at each position
  int discarded = 0;                        ///< first impacts of each ball that do not count (conditioning)
  bool drawn_order = false;                 ///< of the balls at each position, by the run's seed
  int replacements = 0;                     ///< shots that may be fired again, in all
  NominalImpact impact;
  std::vector<Conformance> conforms;
  std::vector<Input> inputs;
  std::vector<Computed> computed;
  std::vector<Requirement> requirements;
  std::vector<std::string> preparation;   ///< for the operator, before the first shot, a sentence each
  std::vector<std::string> not_measured;  ///< what of the document such a rig cannot measure, a sentence each
  std::string report;                     ///< a paragraph for the report
};

/// Fails with "FILE:LINE: key: what".
Result<Protocol> read_protocol(std::string_view text, const std::string& file_name);

/// `name_or_path`: a shipped protocol ("itf-court-pace"), or a path to a file that ends in .toml.
Result<Protocol> load_protocol(const std::string& name_or_path);

/// The file's text, as a session keeps it.
Result<std::string> protocol_text(const std::string& name_or_path);

Result<std::vector<std::string>> shipped_protocols();

}  // namespace strobe::protocol
