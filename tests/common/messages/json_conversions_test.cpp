// Frames as lines of JSON.
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "common/messages/json_conversions.hpp"
#include "common/messages/parsed_json.hpp"
#include "tests/support/error_of.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::messages;
using reduction::Frame;
using reduction::Leg;

namespace {

const std::string kExample =
    R"({"shot_id":1,"ball_diameter_m":0.0651,"surface_px":[[0,1],[10,1.5],[20,2],[30,2.5]],"centre_sd_px":2.0,)"
    R"("diameter_sd_px":3.0,"equator_sd_rad":0.017,"images":[{"time_s":0.0,"leg":"incoming","centre_px":[1,2],)"
    R"("diameter_px":260.0,"equator_rad":0.3},{"time_s":0.003,"leg":"contact","centre_px":[3,4],"diameter_px":250}]})";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  return at == std::string::npos ? "no " + from : text.replace(at, from.size(), to);
}

std::string complaint(const std::string& text) { return testing::error_of(frame_from_json(text)); }

}  // namespace

TEST_GROUP(FrameJson){};

TEST(FrameJson, ReadsTheDocumentedExample) {
  const auto frame = frame_from_json(kExample);
  CHECK_TRUE(frame.has_value());
  LONGS_EQUAL(1, frame->shot_id);
  DOUBLES_EQUAL(0.0651, frame->ball_diameter_m, 0.0);
  LONGS_EQUAL(4, frame->surface_px.size());
  DOUBLES_EQUAL(1.5, frame->surface_px[1].y, 0.0);
  DOUBLES_EQUAL(3.0, *frame->diameter_sd_px, 0.0);
  CHECK_FALSE(frame->px_per_m.has_value());
  LONGS_EQUAL(2, frame->images.size());
  CHECK_EQUAL(Leg::contact, frame->images[1].leg);
  DOUBLES_EQUAL(0.3, *frame->images[0].equator_rad, 0.0);
  CHECK_FALSE(frame->images[1].equator_rad.has_value());
}

TEST(FrameJson, ReadsWhatIsOptional) {
  std::string text = replaced(
      kExample, R"("centre_sd_px":2.0)",
      R"("px_per_m":4000,"px_per_m_sd":8,"ball_diameter_sd_m":0.0008,"surface_angle_deg":-2.5,)"
      R"("ball_mass_kg":0.058,"ball_alpha":0.5,"ball_alpha_sd":0.02,"air_density_kgpm3":1.1,"temperature_c":21,"surface_sd_px":1.5,"record":{"operator":"A","n":12,"x":0.1,"none":null})");
  text = replaced(
      text, R"("equator_rad":0.3)",
      R"("equator_rad":0.3,"time_sd_s":1e-6,"flash_index":77,"centre_cov_px2":[[4,1],[1,9]],)"
      R"("diameter_sd_px":2,"equator_sd_rad":0.02,"top_px":[1,9],"contact_width_px":30,"source":"hand")");
  const auto frame = frame_from_json(text);
  CHECK_TRUE(frame.has_value());
  DOUBLES_EQUAL(4000.0, *frame->px_per_m, 0.0);
  DOUBLES_EQUAL(0.058, *frame->ball_mass_kg, 0.0);
  DOUBLES_EQUAL(0.5, *frame->ball_alpha, 0.0);
  DOUBLES_EQUAL(0.02, *frame->ball_alpha_sd, 0.0);
  DOUBLES_EQUAL(1.1, *frame->air_density_kgpm3, 0.0);
  DOUBLES_EQUAL(-2.5, frame->surface_angle_deg, 0.0);
  DOUBLES_EQUAL(21.0, *frame->temperature_c, 0.0);
  CHECK_EQUAL("12", frame->record.at("n"));
  CHECK_EQUAL("0.1", frame->record.at("x"));
  CHECK_FALSE(frame->record.contains("none"));
  const auto& image = frame->images[0];
  LONGS_EQUAL(77, *image.flash_index);
  DOUBLES_EQUAL(9.0, (*image.centre_cov_px2)[3], 0.0);
  DOUBLES_EQUAL(9.0, image.top_px->y, 0.0);
  CHECK_EQUAL("hand", image.source);
}

TEST(FrameJson, IgnoresUnknownKeysAndTakesNullForAbsent) {
  const auto frame =
      frame_from_json(replaced(kExample, R"("centre_sd_px":2.0)", R"("centre_sd_px":null,"colour":[1])"));
  CHECK_TRUE(frame.has_value());
  CHECK_FALSE(frame->centre_sd_px.has_value());
}

TEST(FrameJson, AnErrorNamesTheField) {
  CHECK_EQUAL("images[1].centre_px: must be two numbers", complaint(replaced(kExample, "[3,4]", "[3]")));
  CHECK_EQUAL("images[1].centre_px: must be two numbers",
              complaint(replaced(kExample, "[3,4]", R"([3,"4"])")));
  CHECK_EQUAL("images[0].diameter_px: must be a number", complaint(replaced(kExample, "260.0", R"("260")")));
  CHECK_EQUAL("images[0].leg: must be incoming, contact or rebound",
              complaint(replaced(kExample, "incoming", "upward")));
  CHECK_EQUAL("images[0].time_s: is missing", complaint(replaced(kExample, R"("time_s":0.0,)", "")));
  CHECK_EQUAL("ball_diameter_m: is missing",
              complaint(replaced(kExample, R"("ball_diameter_m":0.0651,)", "")));
  CHECK_EQUAL("surface_px[2]: must be two numbers", complaint(replaced(kExample, "[20,2]", "20")));
  CHECK_EQUAL("surface_px: must be an array of at least two points, or of none",
              complaint(R"({"ball_diameter_m":1,"surface_px":[[0,0]],"images":[]})"));
  CHECK_EQUAL("shot_id: must be a whole number of 32 bits",
              complaint(replaced(kExample, R"("shot_id":1)", R"("shot_id":2147483648)")));
  for (const char* wrong : {"-2147483649", "1.5", R"("1")"}) {
    CHECK_EQUAL("shot_id: must be a whole number of 32 bits",
                complaint(replaced(kExample, R"("shot_id":1)", std::string(R"("shot_id":)") + wrong)));
  }
  for (const char* wrong : {"1", "[[4,1]]", "[[4,1],[1,9],[1,1]]", "[[4,1],7]", "[[4,1],[1]]",
                            "[[4,1],[1,null]]", "[[null,1],[1,9]]"}) {
    CHECK_EQUAL("images[0].centre_cov_px2: must be two rows of two numbers",
                complaint(replaced(kExample, R"("time_s":0.0)",
                                   std::string(R"("time_s":0.0,"centre_cov_px2":)") + wrong)));
  }
  CHECK_EQUAL("images[1].diameter_px: must be a number", complaint(replaced(kExample, ":250", R"(:"250")")));
  CHECK_EQUAL("images[0].diameter_px: is missing",
              complaint(replaced(kExample, R"("diameter_px":260.0,)", "")));
  CHECK_EQUAL("images[0].source: must be text",
              complaint(replaced(kExample, R"("time_s":0.0)", R"("time_s":0.0,"source":1)")));
  CHECK_EQUAL(
      "images[0].time_s: must be a number",
      complaint(replaced(kExample, R"("time_s":0.0,"leg":"incoming")", R"("time_s":"0","leg":"upward")")));
  CHECK_EQUAL("record.a: must be text or a number",
              complaint(replaced(kExample, R"("shot_id":1)", R"("record":{"a":[]})")));
  CHECK_EQUAL("images: must be an array",
              complaint(R"({"ball_diameter_m":1,"surface_px":[[0,0],[1,0]],"images":7})"));
  CHECK_EQUAL("surface_px: must be an array of at least two points, or of none",
              complaint(R"({"ball_diameter_m":1,"surface_px":7,"images":[]})"));
  for (const auto& [errors, wrong] : std::initializer_list<std::pair<const char*, const char*>>{
           {"7", "map_errors: must be an array"},
           {"[7]", "map_errors[0]: must be an object"},
           {R"([{"images":[]}])", "map_errors[0].surface_px: is missing"},
           {R"([{"images":[[1,2,3]],"surface_px":[]}])",
            "map_errors[0].images[0]: must be four numbers: centre x, y, diameter [px], equator [rad]"},
           {R"([{"images":[],"surface_px":[[1]]}])", "map_errors[0].surface_px[0]: must be two numbers"}}) {
    CHECK_EQUAL(wrong, complaint(replaced(kExample, R"("shot_id":1)",
                                          R"("shot_id":1,"map_errors":)" + std::string(errors))));
  }
  for (const auto& [lens, wrong] : std::initializer_list<std::pair<const char*, const char*>>{
           {"7", "lens: must be an object"},
           {R"({"foot_px":[1,2]})", "lens.distance_m: is missing"},
           {R"({"distance_m":"2","foot_px":[1,2]})", "lens.distance_m: must be a number"},
           {R"({"distance_m":2})", "lens.foot_px: is missing"},
           {R"({"distance_m":2,"foot_px":[1]})", "lens.foot_px: must be two numbers"}}) {
    CHECK_EQUAL(wrong,
                complaint(replaced(kExample, R"("shot_id":1)", R"("shot_id":1,"lens":)" + std::string(lens))));
  }
  CHECK_EQUAL("record: must be an object", complaint(replaced(kExample, R"("shot_id":1)", R"("record":[])")));
  CHECK_EQUAL("images[0]: must be an object",
              complaint(R"({"ball_diameter_m":1,"surface_px":[[0,0],[1,0]],"images":[7]})"));
}

TEST(FrameJson, TextThatIsNotJsonIsSaidByColumn) {
  CHECK_EQUAL("column 2: is not JSON", complaint("{,}"));
  STRCMP_CONTAINS("is not JSON", complaint("").c_str());
  CHECK_EQUAL("must be a JSON object", complaint("[1,2]"));
  STRCMP_CONTAINS("out of range", complaint(R"({"ball_diameter_m":1e999})").c_str());
}

TEST(FrameJson, ReadingAndWritingGivesTheSameBytesOfEveryField) {
  const std::string text =
      R"({"shot_id":-2147483648,"ball_diameter_m":0.0651,"ball_diameter_sd_m":0.0008,"surface_px":[[0.5,1.0],[10.0,1.5]],)"
      R"("surface_sd_px":1.5,"centre_sd_px":2.0,"diameter_sd_px":3.0,"shared_diameter_sd_px":0.5,"equator_sd_rad":0.017,"px_per_m":4000.0,)"
      R"("px_per_m_sd":8.0,"lens":{"distance_m":1.25,"foot_px":[640.0,-0.5]},"map_errors":[{"surface_px":[[0.5,0.0],[1.0,0.0]],"images":[[0.25,0.5,0.125,1e-05]]},)"
      R"({"surface_px":[],"images":[]}],"surface_angle_deg":-2.5,"temperature_c":21.0,"ball_mass_kg":0.058,"ball_alpha":0.5,"ball_alpha_sd":0.02,)"
      R"("air_density_kgpm3":1.1,"record":{"dry":"true","n":"12","operator":"Ä"},"images":[)"
      R"({"time_s":0.25,"leg":"incoming","centre_px":[1.0,2.0],"diameter_px":260.0,"equator_rad":0.30000000000000004,)"
      R"("equator_tilt_rad":-0.25,"equator_tilt_sd_rad":0.0078125,"equator_tilt_correlation":0.5,)"
      R"("time_sd_s":1e-06,"flash_index":2147483647,"centre_cov_px2":[[4.0,1.0],[2.0,9.0]],"diameter_sd_px":2.0,)"
      R"("equator_sd_rad":0.02,"top_px":[3.0,9.0],"contact_width_px":30.0,"probability":0.75,"source":"hand"},)"
      R"({"time_s":0.5,"leg":"contact","centre_px":[3.0,4.0]},)"
      R"({"time_s":0.75,"leg":"rebound","centre_px":[5.0,6.0],"diameter_px":250.0},)"
      R"({"time_s":1.0,"centre_px":[5.0,6.0],"diameter_px":0.0}]})";
  CHECK_EQUAL(text, frame_to_json(frame_from_json(text).value()));
}

TEST(FrameJson, AnImageOfAnotherLegIsWrittenButNotRead) {
  Frame frame = frame_from_json(kExample).value();
  const std::size_t count = frame.images.size();
  frame.images.insert(frame.images.begin(), frame.images.front());
  frame.images.front().other_leg = true;
  frame.images.front().time_s = std::numeric_limits<double>::quiet_NaN();
  const std::string text = frame_to_json(frame);
  STRCMP_CONTAINS(R"("other_leg":true)", text.c_str());
  LONGS_EQUAL(count, frame_from_json(text).value().images.size());
}

TEST(FrameJson, BytesThatAreNotUtf8DoNotThrow) {
  Frame frame;
  frame.record["operator"] = "\xff\xfe";
  STRCMP_CONTAINS("operator", frame_to_json(frame).c_str());
}

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

TEST(ReadoutJson, HasALaunchOrALikelyCauseOnlyWhereThereIsOne) {
  Readout r = example();
  CHECK_FALSE(json::parse(readout_to_json(r)).contains("launch"));
  CHECK_FALSE(json::parse(readout_to_json(r)).contains("likely_cause"));
  r.likely_cause = reduction::LikelyCause{reduction::Cause::flash_period, 1.5, 0.25};
  reduction::Launch& launch = r.launch.emplace();
  launch.time_s = 0.003;
  launch.value[Quantity::v_td_mps] = 30.0;
  launch.sd[Quantity::v_td_mps] = 0.5;
  const json object = json::parse(readout_to_json(r));
  CHECK_EQUAL(json({{"cause", "flash_period"}, {"value", 1.5}, {"sd", 0.25}}), object["likely_cause"]);
  CHECK_EQUAL(0.003, object["launch"]["time_s"].get<double>());
  CHECK_EQUAL(30.0, object["launch"]["speed_mps"].get<double>());
  CHECK_TRUE(object["launch"]["omega_radps"].is_null() && object["launch"]["sd"]["angle_deg"].is_null());
  // 1.96 sd hold 95 % of normal errors.
  DOUBLES_EQUAL(0.98, object["launch"]["expanded_uncertainty"]["speed_mps"].get<double>(), 1e-4);
}

TEST(ReadoutJson, HasTheThirdDimensionOnlyWhereSomethingOfItIsTold) {
  using reduction::SpatialQuantity;
  Readout r = example();
  CHECK_FALSE(json::parse(readout_to_json(r)).contains("spatial"));
  reduction::Spatial& spatial = r.spatial.emplace();
  spatial[SpatialQuantity::omega_x_td_radps] = {-40.0, 0.5, 0.25};
  spatial[SpatialQuantity::off_plane_mm] = {3.0, 2.0, 0.0};
  const json object = json::parse(readout_to_json(r))["spatial"];
  CHECK_EQUAL(-40.0, object["omega_x_td_radps"].get<double>());
  CHECK_EQUAL(0.5, object["sd"]["omega_x_td_radps"].get<double>());
  CHECK_EQUAL(0.25, object["sd_systematic"]["omega_x_td_radps"].get<double>());
  CHECK_EQUAL(3.0, object["off_plane_mm"].get<double>());
  for (const auto key : reduction::kSpatialNames) {
    const std::string name(key);
    CHECK_TRUE(object.contains(name) && object["sd"].contains(name) &&
               object["sd_systematic"].contains(name));
  }
  CHECK_TRUE(object["vz_lo_mps"].is_null() && object["sd"]["vz_lo_mps"].is_null());
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

// JSON that others wrote: what nests deeper than any of ours is none.
namespace {

using namespace strobe::messages;
using nlohmann::ordered_json;

ordered_json parsed(const std::string& text) { return parsed_json<ordered_json>(text); }

std::string nested(int depth) {
  const auto levels = static_cast<std::size_t>(depth);
  return std::string(levels, '[') + std::string(levels, ']');
}

}  // namespace

TEST_GROUP(ParsedJson){};

TEST(ParsedJson, WhatNestsTooDeepIsNone) {
  CHECK_FALSE(parsed(nested(kMaxJsonDepth)).is_discarded());
  CHECK_TRUE(parsed(nested(kMaxJsonDepth + 1)).is_discarded());
  CHECK_TRUE(parsed(nested(4'000'000)).is_discarded());
  CHECK_TRUE(parsed("{\"a\":\"\\\\\",\"b\":" + nested(kMaxJsonDepth) + "}").is_discarded());
}

TEST(ParsedJson, BracketsInTextsDoNotCount) {
  const std::string text = "[\"" + std::string(1000, '[') + "\\\"" + std::string(1000, '{') + "\\\\\"]";
  LONGS_EQUAL(1, json_depth(text));
  CHECK_FALSE(parsed(text).is_discarded());
}

TEST(ParsedJson, SoManyBesideEachOtherAreNotDeep) {
  std::string text = "[[]";
  for (int i = 0; i < 1000; ++i) text += ",[{}]";
  CHECK_FALSE(parsed(text + "]").is_discarded());
  for (const char* none : {"", "[", "]]", "\"", "\"\\", "{\"a\"", "\xff"})
    CHECK_TRUE(parsed(none).is_discarded());
}
