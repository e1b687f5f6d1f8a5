// Every protocol that comes with strobe against its source's words, transcribed here a second time and in other units
// where the source gives them.
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "host/protocol/protocol.hpp"
#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

#include <CppUTest/TestHarness.h>

namespace {

using namespace strobe::protocol;

constexpr double kFree = std::numeric_limits<double>::infinity();
constexpr double kInch_m = 0.0254, kMileAnHour_mps = 1609.344 / 3600.0, kKmAnHour_mps = 1.0 / 3.6;

struct Limit {
  const char* requirement;
  double low, high;
};

struct Transcript {
  const char* name;
  SourceRead read;
  const char* words;  ///< of the source that was read
  double drop_m, speed_mps, angle_deg;
  int balls, positions, repeats;
  std::vector<Limit> limits{};
};

constexpr SourceRead kSummary = SourceRead::summary, kNotRead = SourceRead::not_read;

const std::vector<Transcript> kTranscripts{
    {"itf-court-pace", kSummary,
     "deliver the ball at an incident angle of 16 +- 2 degrees and speed of 30 +- 2 m/s; each of the three test balls "
     "three times; maximum uncertainty of +- 0.05 m/s",
     0, 30, 16, 3, 1, 3, {{"speed_uncertainty", -kFree, 0.05}}},
    {"itf-ball-rebound", kSummary,
     "dropping a ball vertically from a height of 254 cm (100 inches), 135-147 cm (53-58 inches); four valid "
     "measurements per ball",
     100 * kInch_m, 0, 0, 1, 1, 4, {{"rebound", 135, 147}}},
    {"fifa-ball-rebound", kSummary,
     "between 135 and 155 cm with a maximum difference of 10 cm between the ball's highest and lowest bounce; each ball "
     "is dropped 10 times on a steel plate from a height of 2 metres; Anzahl der Testmodelle 3",
     2, 0, 0, 3, 1, 10, {{"rebound", 135, 155}, {"difference", -kFree, 10}}},
    {"fifa-turf-vertical", kSummary,
     "Vertical Ball Rebound - 0.60m to 0.85m; from 2 meters three times in 6 different points of the field", 2, 0, 0, 1, 6,
     3, {{"rebound", 0.60, 0.85}}},
    {"fifa-turf-angled", kSummary, "Angle Ball Rebound - Dry 45% to 60%", 0, 50 * kKmAnHour_mps, 15, 1, 6, 3,
     {{"rebound", 45, 60}}},
    {"en-14904-vertical", kNotRead, "", 1.8, 0, 0, 1, 2, 5, {{"share", 90, kFree}}},
    {"en-15330-vertical", kNotRead, "", 2, 0, 0, 1, 2, 5},
    {"en-15330-angled", kNotRead, "", 0, 50 * kKmAnHour_mps, 15, 1, 2, 5},
    {"astm-f1887-cor", kNotRead, "", 0, 60 * kMileAnHour_mps, 90, 1, 1, 6},
    {"astm-f2845-ccor", kNotRead, "", 0, 60 * kMileAnHour_mps, 90, 1, 1, 6},
    {"table-tennis-table", SourceRead::whole,
     "a uniform bounce of about 23cm when a standard ball is dropped on to it from a height of 30cm", 0.30, 0, 0, 1, 6, 3},
    {"table-tennis-ball", kSummary,
     "All 24 balls must rebound to a height of not less than 240mm and not more than 260mm when dropped from a height of "
     "305mm; three determinations",
     0.305, 0, 0, 24, 1, 3, {{"bounce", 240, 260}}},
    {"basketball-rebound", kSummary,
     "dropped from a height of 1.8m (measured to the bottom of the ball) it will rebound to a height of between 1.2 and "
     "1.4m (measured to the top of the ball)",
     1.8, 0, 0, 1, 1, 3, {{"rebound", 1.2, 1.4}}},
    {"padel-ball-rebound", kSummary, "zwischen 135 und 145 cm, wenn der Ball in einer Hoehe von 2,54 m", 2.54, 0, 0, 1, 1, 3,
     {{"rebound", 135, 145}}},
    {"pickleball-bounce", kSummary,
     "a bounce of 30 to 34 inches when dropped from a height of 78 inches to the top of the ball; 2.874 to 2.972 inches in "
     "diameter",
     78 * kInch_m - 0.5 * (2.874 + 2.972) * kInch_m, 0, 0, 1, 1, 3, {{"bounce", 30, 34}}},
    {"thesis-conditions", kSummary, "zero, top and back spin at seven angles each", 0, 17, 23, 1, 21, 8},
};

Protocol loaded(const std::string& name) {
  const auto protocol = load_protocol(name);
  CHECK_TEXT(protocol.has_value(), protocol ? "" : protocol.error().message.c_str());
  return *protocol;
}

const Requirement& requirement_of(const Protocol& protocol, const std::string& name) {
  for (const Requirement& r : protocol.requirements)
    if (r.name == name) return r;
  FAIL((protocol.name + " does not require " + name).c_str());
  return protocol.requirements.front();
}

}  // namespace

TEST_GROUP(ShippedProtocols){};

TEST(ShippedProtocols, AreAllTranscribed) {
  std::set<std::string> transcribed;
  for (const Transcript& t : kTranscripts) transcribed.insert(t.name);
  const auto shipped = shipped_protocols();
  CHECK(shipped.has_value());
  CHECK(transcribed == std::set<std::string>(shipped->begin(), shipped->end()));
}

TEST(ShippedProtocols, SayWhatTheirSourcesSay) {
  for (const Transcript& t : kTranscripts) {
    const Protocol protocol = loaded(t.name);
    CHECK_TEXT(protocol.source.read == t.read, t.name);
    CHECK_TEXT((protocol.impact.kind == ImpactKind::dropped) == (t.drop_m > 0.0), t.name);
    DOUBLES_EQUAL_TEXT(t.drop_m, protocol.impact.drop_height_m, 1e-4, t.name);  // a tenth of a millimetre of 78 inches
    DOUBLES_EQUAL_TEXT(t.speed_mps, protocol.impact.speed_mps, 1e-12, t.name);
    DOUBLES_EQUAL_TEXT(t.angle_deg, protocol.impact.angle_deg, 0.0, t.name);
    LONGS_EQUAL_TEXT(t.balls, protocol.balls, t.name);
    LONGS_EQUAL_TEXT(t.positions, protocol.positions.size(), t.name);
    LONGS_EQUAL_TEXT(t.repeats, protocol.repeats, t.name);
    for (const Limit& limit : t.limits) {
      const Requirement& r = requirement_of(protocol, limit.requirement);
      CHECK_TEXT(r.limits.low == limit.low && r.limits.high == limit.high, t.name);
    }
    if (protocol.name != "itf-court-pace") LONGS_EQUAL_TEXT(t.limits.size(), protocol.requirements.size(), t.name);
  }
}

TEST(ShippedProtocols, CourtPaceIsTheFormulaAndTheFiveCategoriesOfTheItf) {
  // CPR = 100 (1 - mu) + 150 (0.81 - e_T), e_T = e + 0.003 (23 - T); spin of no more than 3 rev/s; 16 +- 2 degrees
  const Protocol protocol = loaded("itf-court-pace");
  std::set<std::string> formulas;
  for (const Computed& computed : protocol.computed) formulas.insert(computed.formula.text);
  CHECK(formulas.contains("100*(1 - mu) + 150*(0.81 - e_T)") && formulas.contains("e + 0.003*(23 - temperature_c)"));
  for (const Conformance& c : protocol.conforms) {
    if (c.quantity == "omega_td_radps") DOUBLES_EQUAL(6.0 * std::numbers::pi, c.allowed.high, 1e-12);
    if (c.quantity == "theta_in_deg") CHECK(c.allowed.low == -18.0 && c.allowed.high == -14.0);
    if (c.quantity == "v_td_mps") CHECK(c.allowed.low == 28.0 && c.allowed.high == 32.0);
  }
  LONGS_EQUAL(3, protocol.conforms.size());
  LONGS_EQUAL(5, requirement_of(protocol, "rating").categories.size());
}

TEST(ShippedProtocols, SayWhereTheyWereReadAndWhatIsNotMeasured) {
  const std::string readme = strobe::testing::read_text(std::string(STROBE_SOURCE_DIR) + "/common/data/protocols/README.md");
  for (const Transcript& t : kTranscripts) {
    const Protocol protocol = loaded(t.name);
    CHECK_TEXT(protocol.source.where.size() > 20 && !protocol.not_measured.empty(), t.name);
    const std::string read = t.read == kSummary ? "summary" : t.read == kNotRead ? "not read" : "whole";
    const std::size_t at = readme.find("| `" + protocol.name + "` |");
    CHECK_TEXT(at != std::string::npos, t.name);
    const std::string row = readme.substr(at, readme.find('\n', at) - at);
    CHECK_TEXT(row.find("| " + read + " |") != std::string::npos, row.c_str());
    const bool decides = t.read != kNotRead && !protocol.requirements.empty();
    CHECK_TEXT(decides == (row.find("| - ") == std::string::npos), row.c_str());
  }
}
