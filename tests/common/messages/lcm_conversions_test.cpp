// Frames, readouts and records as LCM messages.

// g++ 12 sees overlapping copies in assignments to std::string and unread bytes in the generated decoders
// (GCC bugs 105329, 105651).
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

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::messages;
using reduction::Frame;
using reduction::Leg;
using reduction::Quantity;
using reduction::Readout;

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

Frame example_frame() {
  Frame frame;
  frame.shot_id = 5;
  frame.surface_px = {{0, 1}, {10, 2}};
  frame.centre_sd_px = 2.0;
  frame.images.resize(3);
  frame.images[0].leg = Leg::incoming;
  frame.images[0].equator_rad = 0.4;
  frame.images[1].leg = Leg::contact;
  frame.images[1].top_px = reduction::PointPx{4, 5};
  for (auto& image : frame.images) image.centre_px = {1, 2}, image.diameter_px = 260, image.source = "hand";
  frame.images[2].source = "auto";
  frame.images[2].centre_cov_px2 = {0.01, -0.002, -0.002, 0.02};
  frame.images[2].diameter_sd_px = 0.125;
  frame.images[2].equator_rad = 0.5;
  frame.images[2].equator_sd_rad = 0.0625;
  frame.images[1].contact_width_px = 88.5;
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

template <typename Message>
std::string complaint(const Message& message) {
  if constexpr (std::is_same_v<Message, strobe_msgs::frame_t>) {
    const auto result = frame_from_lcm(message);
    return result ? "accepted" : result.error().message;
  } else {
    const auto result = readout_from_lcm(message);
    return result ? "accepted" : result.error().message;
  }
}

}  // namespace

TEST_GROUP(FrameMessage) { strobe_msgs::frame_t message = frame_to_lcm(example_frame()); };

TEST(FrameMessage, SurvivesTheWire) {
  const auto frame = frame_from_lcm(wired(message));
  CHECK_TRUE(frame.has_value());
  STRCMP_EQUAL(frame_to_json(example_frame()).c_str(), frame_to_json(*frame).c_str());
  CHECK_FALSE(frame->diameter_sd_px.has_value());
  CHECK_FALSE(frame->images[2].leg.has_value());
  CHECK_FALSE(frame->images[1].equator_rad.has_value());
  CHECK_FALSE(frame->images[0].centre_cov_px2.has_value());
  STRCMP_EQUAL("hand", frame->images[1].source.c_str());
  STRCMP_EQUAL("auto", frame->images[2].source.c_str());
}

TEST(FrameMessage, IsCheckedFieldByField) {
  auto bad = message;
  bad.images[2].centre_y_px = kNone;
  STRCMP_EQUAL("images[2].centre_px: must be two finite numbers", complaint(bad).c_str());
  bad = message;
  bad.images[0].diameter_px = -1;
  STRCMP_EQUAL("images[0].diameter_px: must be positive", complaint(bad).c_str());
  bad = message;
  bad.images[0].leg = 9;
  STRCMP_EQUAL("images[0].leg: unknown leg 9", complaint(bad).c_str());
  bad = message;
  bad.images[0].source = 3;
  STRCMP_EQUAL("images[0].source: unknown source 3", complaint(bad).c_str());
  bad = message;
  bad.images[2].centre_xy_px2 = 0.015;
  STRCMP_CONTAINS("images[2].centre_xx_px2, xy, yy: must be positive definite", complaint(bad).c_str());
  bad = message;
  bad.images[0].centre_xx_px2 = 1.0;  // alone
  STRCMP_CONTAINS("images[0].centre_xx_px2, xy, yy", complaint(bad).c_str());
  bad = message;
  bad.images[2].diameter_sd_px = 0.0;
  STRCMP_CONTAINS("images[2].diameter_sd_px: must be positive", complaint(bad).c_str());
  bad = message;
  bad.images[2].equator_sd_rad = INFINITY;
  STRCMP_CONTAINS("images[2].equator_sd_rad: must be positive", complaint(bad).c_str());
  bad = message;
  bad.images[1].contact_width_px = -1.0;
  STRCMP_CONTAINS("images[1].contact_width_px: must be positive", complaint(bad).c_str());
  bad = message;
  bad.centre_sd_px = 0.0;
  STRCMP_CONTAINS("centre_sd_px: must be positive", complaint(bad).c_str());
  bad = message;
  bad.surface[1].x_px = INFINITY;
  STRCMP_EQUAL("surface[1]: must be two finite numbers", complaint(bad).c_str());
  bad = message;
  bad.schema_version = 1;
  STRCMP_EQUAL("schema_version: is 1, known is 2", complaint(bad).c_str());
  bad = message;
  bad.image_count = 1000;
  STRCMP_CONTAINS("image_count", complaint(bad).c_str());
  bad = message;
  bad.surface.resize(1), bad.surface_count = 1;
  STRCMP_CONTAINS("surface: needs at least two points", complaint(bad).c_str());
}

TEST(FrameMessage, MayHaveNoSurfaceAndAContactImageWithoutADiameter) {
  message.surface.clear(), message.surface_count = 0;
  message.images[1].diameter_px = kNone;
  const auto frame = frame_from_lcm(wired(message));
  CHECK_TRUE(frame.has_value());
  CHECK_TRUE(frame->surface_px.empty());
  DOUBLES_EQUAL(0.0, frame->images[1].diameter_px, 0.0);
  CHECK_TRUE(std::isnan(frame_to_lcm(*frame).images[1].diameter_px));
  message.images[0].diameter_px = kNone;  // in flight it must have one
  STRCMP_EQUAL("images[0].diameter_px: must be positive", complaint(message).c_str());
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
    readout.court_pace_conforming = true;
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
  CHECK_TRUE(std::isnan(message.value.theta_out_deg));
  const auto back = readout_from_lcm(message);
  CHECK_TRUE(back.has_value());
  STRCMP_EQUAL(readout_to_json(readout).c_str(), readout_to_json(*back).c_str());
}

TEST(ReadoutMessage, EachFieldCarriesItsOwnQuantity) {
  // theta_in 1, vx_td 3, v_td 5, vx_lo 7, v_lo 9, slip 11, mu 13, dwell distance 15: index + 1 in
  // readout.hpp's order.
  const auto m = readout_to_lcm(readout, 1, 1).value;
  DOUBLES_EQUAL(1.0, m.theta_in_deg, 0.0);
  DOUBLES_EQUAL(3.0, m.vx_td_mps, 0.0);
  DOUBLES_EQUAL(5.0, m.v_td_mps, 0.0);
  DOUBLES_EQUAL(7.0, m.vx_lo_mps, 0.0);
  DOUBLES_EQUAL(9.0, m.v_lo_mps, 0.0);
  DOUBLES_EQUAL(11.0, m.slip_lo_mps, 0.0);
  DOUBLES_EQUAL(13.0, m.mu, 0.0);
  DOUBLES_EQUAL(15.0, m.dwell_distance_cm, 0.0);
}

TEST(ReadoutMessage, IsChecked) {
  auto bad = readout_to_lcm(readout, 1, 1);
  bad.flags[0] = "haunted";
  STRCMP_EQUAL("flags: unknown flag \"haunted\"", complaint(bad).c_str());
  bad = readout_to_lcm(readout, 1, 1);
  bad.flight_effects[1] = "wind";
  STRCMP_EQUAL("flight_effects: unknown effect \"wind\"", complaint(bad).c_str());
  bad = readout_to_lcm(readout, 1, 1);
  bad.regime = "floats";
  STRCMP_EQUAL("regime: unknown word \"floats\"", complaint(bad).c_str());
  bad = readout_to_lcm(readout, 1, 1);
  bad.sd.mu = INFINITY;
  STRCMP_CONTAINS("sd.mu: must be finite", complaint(bad).c_str());
  bad = readout_to_lcm(readout, 1, 1);
  bad.schema_version = 0;
  STRCMP_CONTAINS("schema_version", complaint(bad).c_str());
}

TEST_GROUP(RecordNotes){};

TEST(RecordNotes, KeepEveryEntry) {
  const reduction::Record record{{"operator", "A"}, {"remarks", "wind, rain"}, {"angle_deg", "23"}};
  const auto back = record_from_notes(notes_from_record(record));
  CHECK_TRUE(back.has_value());
  CHECK_TRUE(*back == record);
}

TEST(RecordNotes, AreCheckedForKeyAndLength) {
  std::vector<strobe_msgs::note_t> notes(2);
  notes[0].key = "operator";
  notes[1].key = "Operator";
  STRCMP_CONTAINS("notes[1].key", record_from_notes(notes).error().message.c_str());
  notes[1].key = "remarks";
  notes[1].value = std::string(1025, 'x');
  STRCMP_CONTAINS("notes[1].value", record_from_notes(notes).error().message.c_str());
  notes.assign(65, notes[0]);
  STRCMP_CONTAINS("at most 64", record_from_notes(notes).error().message.c_str());
}

TEST(RecordNotes, ALaterNoteOverridesAnEarlierOne) {
  std::vector<strobe_msgs::note_t> notes(2);
  notes[0].key = notes[1].key = "operator";
  notes[0].value = "A";
  notes[1].value = "B";
  STRCMP_EQUAL("B", record_from_notes(notes)->at("operator").c_str());
}
