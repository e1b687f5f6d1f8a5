// A step of commissioning and what it found: a number against its limit, in words, and what to do. Plain
// values; thread-safe.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace strobe::commission {

enum class StepState {
  pending,  ///< not begun
  running,
  waiting,  ///< for a person, or for what nothing can be fired without
  passed,
  failed,
  skipped,   ///< by a person, or since the rig has not what it asks of; never a pass
  not_told,  ///< measured, but too uncertain to be told apart from a limit (guard_band.hpp); never a pass
};
/// In the record.
inline constexpr std::array<std::string_view, 7> kStateNames{"pending", "running", "waiting", "passed",
                                                             "failed",  "skipped", "not_told"};
constexpr std::string_view name(StepState state) { return kStateNames[static_cast<std::size_t>(state)]; }
/// For a person.
constexpr std::string_view in_words(StepState state) {
  return state == StepState::not_told ? "not told apart" : name(state);
}
constexpr bool over(StepState state) { return state >= StepState::passed; }
/// Over, and nothing is left to be mended or told.
constexpr bool is_settled(StepState state) {
  return state == StepState::passed || state == StepState::skipped;
}

/// One line of the record. A Step may answer several, from the same shots.
struct StepInfo {
  std::string id;     ///< "lamp_a": letters, digits and _; in the record for ever
  std::string title;  ///< "lamp A alone"
  /// The rig file's tables on which the result depends: where one of them has changed since, the step is
  /// repeated.
  std::vector<std::string> tables;
};

/// One measured number.
struct Figure {
  std::string name;  ///< key in JSON, with its unit: "delay_a_us"
  double value = 0.0;
  std::optional<double> sd;        ///< standard uncertainty of the value
  std::optional<double> expected;  ///< the rig file's, or the place's
  int count = 0;                   ///< of what it is the mean; 0: no mean
};

struct StepResult {
  std::string id;  ///< of the step that it answers; Commissioning enters it
  StepState state = StepState::failed;
  std::optional<double> value;  ///< the one number by which the step passes or fails
  std::optional<double> sd;     ///< its standard uncertainty
  std::string unit;             ///< of both: "us"; may be empty
  std::string limit;            ///< in words: "within 3 us of the rig file's 12.0"; may be empty
  std::string words;   ///< what was found, one sentence: "lamp A flashes 12.1 ± 0.3 us after its pulse"
  std::string advice;  ///< what to do, one sentence; may be empty
  std::string fault;   ///< failed: its name for scripts, such as "sensors_swapped"; empty where it has none
  std::vector<Figure> figures;  ///< all that was measured
};

/// Of steps that nothing was measured in.
inline StepResult skipped(std::string words, std::string advice = {}) {
  StepResult result;
  result.state = StepState::skipped;
  result.words = std::move(words);
  result.advice = std::move(advice);
  return result;
}
inline StepResult failed(std::string fault, std::string words, std::string advice) {
  StepResult result;
  result.words = std::move(words);
  result.advice = std::move(advice);
  result.fault = std::move(fault);
  return result;
}
/// Has passed, unless hold() (guard_band.hpp) or mark_failed() says otherwise.
inline StepResult passed(std::optional<double> value, std::optional<double> sd, std::string unit,
                         std::string limit) {
  StepResult result;
  result.state = StepState::passed;
  result.value = value;
  result.sd = sd;
  result.unit = std::move(unit);
  result.limit = std::move(limit);
  return result;
}

/// Of a result whose words say what was found.
inline void mark_failed(StepResult& result, std::string fault, std::string advice) {
  result.state = StepState::failed;
  result.fault = std::move(fault);
  result.advice = std::move(advice);
}

}  // namespace strobe::commission
