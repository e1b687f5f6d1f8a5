#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "common/messages/json_conversions.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::messages;
using nlohmann::json;
using reduction::Quantity;
using reduction::Readout;

namespace {

Readout example() {
  Readout r;
  r.shot_id = 3;
  r.value[Quantity::e] = 0.1 + 0.2;
  r.sd[Quantity::e] = 0.047;
  r.sd_systematic[Quantity::e] = 0.0;
  r.regime = Regime::grips;
  r.method = "best";
  r.mirrored = true;
  r.flags.set(reduction::Flag::outlier_image);
  r.flags.set(reduction::Flag::late_flash);
  r.record["operator"] = "Ä \"quoted\" name";
  return r;
}

}  // namespace

TEST_GROUP(ReadoutJson){};

TEST(ReadoutJson, HasEveryDocumentedName) {
  const json object = json::parse(readout_to_json(example()));
  for (const char* key : {"shot_id", "regime", "court_pace_conforming", "method", "mirrored",
                          "flight_effects", "flags", "record", "sd", "sd_systematic", "degrees_of_freedom",
                          "expanded_uncertainty", "residual_ratio", "residual_ratio_by_kind", "first_flash",
                          "last_flash", "misassignment_probability", "assignments", "sd_assignments"})
    CHECK_TRUE_TEXT(object.contains(key), key);
  for (const char* key : {"theta_in_deg", "theta_out_deg", "vx_td_mps", "vy_td_mps", "v_td_mps",
                          "omega_td_radps", "vx_lo_mps", "vy_lo_mps", "v_lo_mps", "omega_lo_radps",
                          "slip_lo_mps", "e", "mu", "dwell_time_ms", "dwell_distance_cm", "court_pace"}) {
    CHECK_TRUE_TEXT(object.contains(key), key);
    CHECK_TRUE_TEXT(object["sd"].contains(key), key);
    CHECK_TRUE_TEXT(object["sd_systematic"].contains(key), key);
    CHECK_TRUE_TEXT(object["degrees_of_freedom"].contains(key), key);
    CHECK_TRUE_TEXT(object["expanded_uncertainty"].contains(key), key);
  }
}

TEST(ReadoutJson, SaysWhatSeveralAssignmentsOfFlashesAddToTheSd) {
  Readout r = example();
  CHECK_TRUE(json::parse(readout_to_json(r))["assignments"].is_null());
  r.assignments.emplace().hypotheses = 7;
  r.assignments->sd[Quantity::e] = 0.002;
  const json object = json::parse(readout_to_json(r));
  CHECK_EQUAL(json(7), object["assignments"]);
  CHECK_EQUAL(json(0.002), object["sd_assignments"]["e"]);
  CHECK_TRUE(object["sd_assignments"]["mu"].is_null());
}

TEST(ReadoutJson, StatesTheExpandedUncertaintyBesideTheSd) {
  Readout r = example();
  r.degrees_of_freedom[Quantity::e] = 2.0;
  const json object = json::parse(readout_to_json(r));
  CHECK_EQUAL(json(2.0), object["degrees_of_freedom"]["e"]);
  // Student's t of two degrees of freedom: 4.303 for 95 %, 1.321 for 68.27 %.
  DOUBLES_EQUAL(0.047 * 4.303 / 1.321, object["expanded_uncertainty"]["e"].get<double>(), 1e-4);
  CHECK_TRUE(object["expanded_uncertainty"]["mu"].is_null());
}

TEST(ReadoutJson, NamesTheEffectsOfTheFlight) {
  Readout r = example();
  CHECK_EQUAL(json::array(), json::parse(readout_to_json(r))["flight_effects"]);
  r.flight_effects = {.gravity = true, .drag = false, .magnus = true};
  CHECK_EQUAL(json::array({"gravity", "magnus"}), json::parse(readout_to_json(r))["flight_effects"]);
}

TEST(ReadoutJson, WhatIsAbsentIsNull) {
  const json object = json::parse(readout_to_json(example()));
  CHECK_TRUE(object["mu"].is_null());
  CHECK_TRUE(object["sd"]["mu"].is_null());
  Readout without = example();
  without.regime.reset();
  CHECK_TRUE(json::parse(readout_to_json(without))["regime"].is_null());
  CHECK_FALSE(object.contains("far"));
}

TEST(ReadoutJson, StatesTheResidualsOverTheirNoiseWhereItIsStated) {
  Readout r = example();
  CHECK_TRUE(json::parse(readout_to_json(r))["residual_ratio"].is_null());
  r.residual_ratios.all = 2.5;
  r.residual_ratios.by_kind[static_cast<std::size_t>(reduction::MeasurementKind::surface)] = 0.5;
  STRCMP_CONTAINS(
      R"("residual_ratio":2.5,"residual_ratio_by_kind":{"centre":null,"equator":null,"diameter":null,"surface":0.5},)",
      readout_to_json(r).c_str());
}

TEST(ReadoutJson, NamesTheFlashesOfAMatchedPhotographAndTheirMisassignmentProbability) {
  Readout r = example();
  CHECK_TRUE(json::parse(readout_to_json(r))["misassignment_probability"].is_null());
  r.flashes = reduction::ImagedFlashes{25, 37, 0.0625, true};
  STRCMP_CONTAINS(R"("first_flash":25,"last_flash":37,"misassignment_probability":0.0625,)",
                  readout_to_json(r).c_str());
}

TEST(ReadoutJson, ANumberThatIsNotFiniteIsNull) {
  Readout r = example();
  r.value[Quantity::mu] = std::numeric_limits<double>::infinity();
  CHECK_TRUE(json::parse(readout_to_json(r))["mu"].is_null());
}

TEST(ReadoutJson, IsTheSameBytesEachTimeWithShortestNumbers) {
  const std::string text = readout_to_json(example());
  CHECK_EQUAL(text, readout_to_json(example()));
  STRCMP_CONTAINS(R"("e":0.30000000000000004,)", text.c_str());
  STRCMP_CONTAINS(R"("flags":["late_flash","outlier_image"])", text.c_str());
  STRCMP_CONTAINS(R"({"shot_id":3,"theta_in_deg":null,)", text.c_str());
  STRCMP_CONTAINS(R"("record":{"operator":"Ä \"quoted\" name"})", text.c_str());
  CHECK_TRUE(text.find('\n') == std::string::npos);
}

TEST(ReadoutJson, LegacyDetailIsWrittenAsFarAndContact) {
  Readout r = example();
  r.legacy.emplace();
  r.legacy->far[Quantity::e] = 0.7;
  r.legacy->contact.push_back({2.2, 0.1, 0.2, -0.1, 0.3});
  const json object = json::parse(readout_to_json(r));
  DOUBLES_EQUAL(0.7, object["far"]["e"].get<double>(), 0.0);
  DOUBLES_EQUAL(-0.1, object["contact"][0]["y_fraction"].get<double>(), 0.0);
  DOUBLES_EQUAL(2.2, object["contact"][0]["height_cm"].get<double>(), 0.0);
}
