// Frames, readouts and records as LCM messages.

// g++ 12 sees overlapping copies in assignments to std::string and unread bytes in the generated decoders
// (GCC bugs 105329, 105651).
#include "common/messages/plan_lcm.hpp"

#include <CppUTest/TestHarness.h>

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wrestrict"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif

#include <cmath>
#include <limits>
#include <string>
#include <strobe_msgs/frame_t.hpp>
#include <strobe_msgs/readout_t.hpp>

#include "common/messages/json_conversions.hpp"
#include "common/messages/lcm_conversions.hpp"
#include "common/messages/record.hpp"

#include "tests/support/error_of.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::messages;
using namespace reduction;

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

Frame example_frame() {
  Frame frame;
  frame.shot_id = 5;
  frame.surface_px = {{0, 1}, {10, 2}};
  frame.centre_sd_px = 2.0, frame.surface_sd_px = 1.5, frame.diameter_sd_px = 3.0,
  frame.equator_sd_rad = 0.02;
  frame.px_per_m = 4000.0, frame.px_per_m_sd = 8.0;
  frame.images.resize(4);
  frame.images[0].leg = Leg::incoming;
  frame.images[0].equator_rad = 0.4;
  frame.images[1].leg = Leg::contact;
  frame.images[1].top_px = reduction::PointPx{4, 5};
  for (auto& image : frame.images) image.centre_px = {1, 2}, image.diameter_px = 260, image.source = "hand";
  frame.images[2].source = "auto";
  frame.images[2].centre_cov_px2 = {0.01, -0.002, -0.002, 0.02};
  frame.images[2].diameter_sd_px = 0.125;
  frame.shared_diameter_sd_px = 0.0625;
  frame.images[2].equator_rad = 0.5;
  frame.images[2].equator_sd_rad = 0.0625;
  frame.images[2].equator_tilt_rad = -0.25, frame.images[2].equator_tilt_sd_rad = 0.03125;
  frame.images[2].equator_tilt_correlation = 0.5;
  frame.images[1].contact_width_px = 88.5;
  frame.images[2].probability = 0.75;
  frame.images[3].leg = Leg::rebound;
  return frame;
}

/// Through the wire's bytes, as a receiver gets it.
template <typename Message>
Message wired(const Message& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  Message result;
  LONGS_EQUAL(static_cast<long>(bytes.size()),
              result.decode(bytes.data(), 0, static_cast<int>(bytes.size())));
  return result;
}

std::string complaint(const strobe_msgs::frame_t& message) {
  return testing::error_of(frame_from_lcm(message));
}

}  // namespace

TEST_GROUP(FrameMessage) { strobe_msgs::frame_t message = frame_to_lcm(example_frame()); };

TEST(FrameMessage, SurvivesTheWire) {
  const auto frame = frame_from_lcm(wired(message));
  CHECK_TRUE(frame.has_value());
  CHECK_EQUAL(frame_to_json(example_frame()), frame_to_json(*frame));
  CHECK_FALSE(frame->images[2].leg.has_value());
  CHECK_FALSE(frame->images[1].equator_rad.has_value());
  CHECK_FALSE(frame->images[0].centre_cov_px2.has_value());
  CHECK_EQUAL("hand", frame->images[1].source);
  CHECK_EQUAL("auto", frame->images[2].source);
  // What is absent stays so.
  Frame bare;
  bare.surface_px = {{0, 1}, {10, 2}};
  bare.images.resize(1);
  bare.images[0].diameter_px = 1.0;
  CHECK_EQUAL(frame_to_json(bare), frame_to_json(*frame_from_lcm(wired(frame_to_lcm(bare)))));
}

TEST(FrameMessage, LeavesOutImagesOfOtherLegs) {
  Frame frame = example_frame();
  frame.images[0].other_leg = true;
  message = frame_to_lcm(frame);
  LONGS_EQUAL(3, message.image_count);
  LONGS_EQUAL(3, message.images.size());
  LONGS_EQUAL(strobe_msgs::ball_image_t::LEG_CONTACT, message.images[0].leg);
}

TEST(FrameMessage, SaysTheSourceOfMostImagesTheEarlierOfEquals) {
  Frame frame = example_frame();
  CHECK_EQUAL("hand", message.source);
  frame.images[0].source = "auto";  // two of each
  CHECK_EQUAL("auto", frame_to_lcm(frame).source);
  frame.images[3].source = "film";  // no other word has a number of its own
  CHECK_EQUAL("auto", frame_from_lcm(frame_to_lcm(frame))->images[3].source);
}

TEST(FrameMessage, IsCheckedFieldByField) {
  const auto refused = [&](const char* why, const auto& change) {
    auto bad = message;
    change(bad);
    CHECK_EQUAL(why, complaint(bad));
  };
  using M = strobe_msgs::frame_t;
  const char* const definite =
      "images[2].centre_xx_px2, xy, yy: must be positive definite, or NaN for unknown";
  refused("images[2].centre_px: must be two finite numbers", [](M& m) { m.images[2].centre_y_px = kNone; });
  refused("images[2].centre_px: must be two finite numbers", [](M& m) { m.images[2].centre_x_px = kNone; });
  refused("images[0].diameter_px: must be positive", [](M& m) { m.images[0].diameter_px = 0.0; });
  refused("images[0].diameter_px: must be positive", [](M& m) { m.images[0].diameter_px = INFINITY; });
  refused("images[1].diameter_px: must be positive", [](M& m) { m.images[1].diameter_px = -1.0; });
  refused("images[1].equator_rad: must be finite, or NaN for not seen",
          [](M& m) { m.images[1].equator_rad = -INFINITY; });
  refused("images[2].equator_tilt_rad: must be finite, or NaN for not seen",
          [](M& m) { m.images[2].equator_tilt_rad = INFINITY; });
  refused("images[2].equator_tilt_correlation: must be finite, or NaN for not seen",
          [](M& m) { m.images[2].equator_tilt_correlation = INFINITY; });
  refused("images[0].leg: unknown leg 9", [](M& m) { m.images[0].leg = 9; });
  refused("images[0].source: unknown source 3", [](M& m) { m.images[0].source = 3; });
  refused(definite, [](M& m) { m.images[2].centre_xy_px2 = std::sqrt(0.01) * std::sqrt(0.02); });
  refused(definite, [](M& m) { m.images[2].centre_xy_px2 = kNone; });
  refused(definite, [](M& m) { m.images[2].centre_xx_px2 = kNone; });
  refused(definite, [](M& m) { m.images[2].centre_yy_px2 = INFINITY; });
  refused(definite, [](M& m) { m.images[2].centre_xx_px2 = m.images[2].centre_yy_px2 = -1.0; });
  const auto positive = [&](const char* field, auto change) {
    for (const double bad : {-1.0, static_cast<double>(INFINITY)})
      refused((std::string(field) + ": must be positive, or NaN for unknown").c_str(),
              [&](M& m) { change(m) = bad; });
  };
  positive("images[2].diameter_sd_px", [](M& m) -> double& { return m.images[2].diameter_sd_px; });
  positive("images[2].equator_sd_rad", [](M& m) -> double& { return m.images[2].equator_sd_rad; });
  positive("images[2].equator_tilt_sd_rad",
           [](M& m) -> double& { return m.images[2].equator_tilt_sd_rad; });
  positive("images[2].probability", [](M& m) -> double& { return m.images[2].probability; });
  positive("images[1].contact_width_px", [](M& m) -> double& { return m.images[1].contact_width_px; });
  positive("centre_sd_px", [](M& m) -> double& { return m.centre_sd_px; });
  positive("diameter_sd_px", [](M& m) -> double& { return m.diameter_sd_px; });
  refused("shared_diameter_sd_px: must be positive, or NaN for unknown",
          [](M& m) { m.shared_diameter_sd_px = -1.0; });
  positive("surface_sd_px", [](M& m) -> double& { return m.surface_sd_px; });
  positive("equator_sd_rad", [](M& m) -> double& { return m.equator_sd_rad; });
  positive("px_per_m", [](M& m) -> double& { return m.px_per_m; });
  positive("px_per_m_sd", [](M& m) -> double& { return m.px_per_m_sd; });
  refused("px_per_m: must be positive, or NaN for unknown", [](M& m) { m.px_per_m = 0.0; });
  refused("surface[1]: must be two finite numbers", [](M& m) { m.surface[1].x_px = INFINITY; });
  refused("surface[0]: must be two finite numbers", [](M& m) { m.surface[0].y_px = kNone; });
  refused("schema_version: is 1, known is 5", [](M& m) { m.schema_version = 1; });
  const char* const counts = "surface_count, image_count: do not fit the arrays";
  refused(counts, [](M& m) { m.image_count = 1000; });
  refused(counts, [](M& m) { m.surface_count = 3; });
  refused("surface: needs at least two points, or none",
          [](M& m) { m.surface_count = 1, m.surface.resize(1); });
  refused("surface: needs at least two points, or none",
          [](M& m) { m.surface_count = 10001, m.surface.resize(10001); });
  refused("images: at most 512 are allowed", [](M& m) { m.image_count = 513, m.images.resize(513); });
  message.surface.resize(10000, message.surface[0]), message.surface_count = 10000;
  message.images.resize(512, message.images[0]), message.image_count = 512;
  CHECK_EQUAL("", complaint(message));
  // Arrays that are empty, whatever their counts claim.
  message.surface.clear(), message.images.clear();
  message.surface_count = message.image_count = -1;
  CHECK_EQUAL("", complaint(message));
}

TEST(FrameMessage, MayHaveNoSurfaceAndAContactImageWithoutADiameter) {
  message.surface.clear(), message.surface_count = 0;
  message.images[1].diameter_px = kNone;
  const auto frame = frame_from_lcm(wired(message));
  CHECK_TRUE(frame.has_value());
  CHECK_TRUE(frame->surface_px.empty());
  DOUBLES_EQUAL(0.0, frame->images[1].diameter_px, 0.0);
  CHECK_TRUE(std::isnan(frame_to_lcm(*frame).images[1].diameter_px));
  message.images[1].top_x_px = kNone;  // half a point is none
  CHECK_FALSE(frame_from_lcm(message)->images[1].top_px.has_value());
  message.images[0].diameter_px = kNone;  // in flight it must have one
  CHECK_EQUAL("images[0].diameter_px: must be positive", complaint(message));
}

TEST(FrameMessage, AnExactScaleSurvives) {
  Frame frame = example_frame();
  frame.px_per_m = 4000.0;
  frame.px_per_m_sd = 0.0;
  DOUBLES_EQUAL(0.0, *frame_from_lcm(wired(frame_to_lcm(frame)))->px_per_m_sd, 0.0);
}

TEST_GROUP(ReadoutMessage) {
  Readout readout;
  void setup() override {
    readout.shot_id = 9;
    for (std::size_t i = 0; i < reduction::kQuantityCount; i += 2) {
      readout.value[static_cast<Quantity>(i)] = 1.0 + static_cast<double>(i);
      readout.sd[static_cast<Quantity>(i)] = 0.5 + static_cast<double>(i);
    }
    readout.sd_systematic[Quantity::v_td_mps] = 0.2;
    readout.regime = Regime::slides;
    readout.court_pace_conforming = readout.mirrored = true;
    readout.method = "two-point";
    readout.flight_effects = {.gravity = true, .drag = true, .magnus = false};
    readout.flags.set(reduction::Flag::sensor_missing);
    readout.record["operator"] = "A";
  }
};

TEST(ReadoutMessage, SurvivesTheWire) {
  const strobe_msgs::readout_t message = wired(readout_to_lcm(readout, 11, 22));
  CHECK_EQUAL(11, message.host_id);
  CHECK_EQUAL(22, message.boot_id);
  LONGS_EQUAL(9, message.shot_id);
  LONGS_EQUAL(strobe_msgs::readout_t::SCHEMA_VERSION, message.schema_version);
  CHECK_TRUE(std::isnan(message.value.theta_out_deg));
  DOUBLES_EQUAL(12.5, message.sd.mu, 0.0);
  CHECK_TRUE(std::isnan(message.sd.e));
  DOUBLES_EQUAL(0.2, message.sd_systematic.v_td_mps, 0.0);
  CHECK_TRUE(std::isnan(message.sd_systematic.mu));
  STRCMP_EQUAL("slides", message.regime.c_str());
  LONGS_EQUAL(1, message.court_pace_conforming);
  STRCMP_EQUAL("two-point", message.method.c_str());
  LONGS_EQUAL(1, message.mirrored);
  CHECK_TRUE(message.flight_effects == (std::vector<std::string>{"gravity", "drag"}));
  CHECK_TRUE(message.flags == std::vector<std::string>{"sensor_missing"});
  CHECK_TRUE(*record_from_notes(message.notes) == readout.record);
  readout = {};
  LONGS_EQUAL(0, readout_to_lcm(readout, 11, 22).mirrored);
  LONGS_EQUAL(0, readout_to_lcm(readout, 11, 22).court_pace_conforming);
  STRCMP_EQUAL("", readout_to_lcm(readout, 11, 22).regime.c_str());
  for (const auto regime : {Regime::grips, Regime::unclear}) {
    readout.regime = regime;
    STRCMP_EQUAL(std::string(name(regime)).c_str(), readout_to_lcm(readout, 1, 2).regime.c_str());
  }
}

TEST(ReadoutMessage, EachFieldCarriesItsOwnQuantity) {
  // Index + 1 in readout.hpp's order.
  for (std::size_t i = 1; i < reduction::kQuantityCount; i += 2)
    readout.value[static_cast<Quantity>(i)] = 1.0 + static_cast<double>(i);
  const auto m = readout_to_lcm(readout, 1, 1).value;
  const double fields[] = {m.theta_in_deg, m.theta_out_deg,  m.vx_td_mps,         m.vy_td_mps,
                           m.v_td_mps,     m.omega_td_radps, m.vx_lo_mps,         m.vy_lo_mps,
                           m.v_lo_mps,     m.omega_lo_radps, m.slip_lo_mps,       m.e,
                           m.mu,           m.dwell_time_ms,  m.dwell_distance_cm, m.court_pace};
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i)
    DOUBLES_EQUAL(1.0 + static_cast<double>(i), fields[i], 0.0);
}

TEST_GROUP(RecordNotes){};

TEST(RecordNotes, KeepEveryEntry) {
  const reduction::Record record{{"operator", "A"}, {"remarks", "wind, rain"}, {"angle_deg", "23"}};
  const auto back = record_from_notes(notes_from_record(record));
  CHECK_TRUE(back.has_value());
  CHECK_EQUAL(record, *back);
}

TEST(RecordNotes, AreCheckedForKeyAndLength) {
  std::vector<strobe_msgs::note_t> notes(2);
  notes[0].key = "operator";
  notes[1].key = "Operator";
  STRCMP_CONTAINS("notes[1].key", record_from_notes(notes).error().message.c_str());
  notes[1].key = "remarks";
  notes[1].value = std::string(1025, 'x');
  STRCMP_CONTAINS("notes[1].value", record_from_notes(notes).error().message.c_str());
  notes[1].value.pop_back();
  CHECK_TRUE(record_from_notes(notes).has_value());
  notes.assign(65, notes[0]);
  STRCMP_CONTAINS("at most 64", record_from_notes(notes).error().message.c_str());
  notes.pop_back();
  CHECK_TRUE(record_from_notes(notes).has_value());
  // The ends of what is allowed, and their neighbours.
  for (const std::string& key : {std::string("az09_."), std::string(64, 'x')})
    CHECK_TRUE(valid_note_key(key));
  for (const std::string& key : {std::string(), std::string(65, 'x'), std::string("a`"), std::string("a{"),
                                 std::string("a/"), std::string("a:"), std::string("a-")})
    CHECK_FALSE_TEXT(valid_note_key(key), key.c_str());
}

TEST(RecordNotes, ALaterNoteOverridesAnEarlierOne) {
  std::vector<strobe_msgs::note_t> notes(2);
  notes[0].key = notes[1].key = "operator";
  notes[0].value = "A";
  notes[1].value = "B";
  CHECK_EQUAL("B", record_from_notes(notes)->at("operator"));
}

using namespace strobe;

TEST_GROUP(PlanMessage){};

TEST(PlanMessage, CarriesAPlanThereAndBack) {
  ShotPlan plan;
  plan.train = Train::gated;
  plan.period = microseconds(1777);
  plan.flash_count = 12;
  plan.exposure = milliseconds(321);
  plan.gate_delay = microseconds(4001);
  plan.impact_at = milliseconds(99);
  plan.dry = true;
  CHECK(messages::plan_from_lcm(messages::plan_to_lcm(plan)) == plan);
}

TEST(PlanMessage, CarriesACodedTrainThereAndBack) {
  ShotPlan plan;
  for (int k = 0; k < 300; ++k)
    plan.code.push_back({microseconds(3000 * k + 7 * k * k), k % 3 == 0   ? Lamps::a
                                                             : k % 3 == 1 ? Lamps::b
                                                                          : Lamps::both});
  CHECK(messages::plan_from_lcm(messages::plan_to_lcm(plan)) == plan);
}
