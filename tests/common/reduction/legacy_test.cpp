// The thesis's program and its file format. Numbers are worked out by hand in the comments, or are those that
// the thesis's errata give for its quirks.
#include <cmath>
#include <numbers>
#include <string>

#include "common/reduction/legacy.hpp"
#include "common/reduction/legacy_file.hpp"
#include "common/reduction/reduce.hpp"
#include "common/reduction/running_statistics.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::reduction;

namespace {

constexpr double kHalfTurn = std::numbers::pi;

LegacyImage image(double x, double y, double equator_rad, double diameter = 65.1) {
  const double dx = 20.0 * std::cos(equator_rad), dy = 20.0 * std::sin(equator_rad);
  return {{x, y}, {x, y + diameter / 2}, {x - dx, y - dy}, {x + dx, y + dy}};
}

/// 1000 units to the metre, flashes every 2 ms, level surface at y = 100; touchdown and lift-off at 132.55.
/// Before: 30 units a flash to the right and 12 down, the last image 2 ms above touchdown at x = 150; from
/// image 1 to 2, 32 and 14. After: 18 and 10 a flash, the first image 1 ms after lift-off at x = 200; then 17
/// and 9. Three flashes in contact: dwell = 4 * 2 - 2 - 1 = 5 ms. Equator: falls by 0.2 a flash, and by 0.3
/// after.
LegacyFrame hand_frame() {
  LegacyFrame f;
  f.period_s = 0.002;
  f.contact_count = 3;
  f.frame_number = 41;
  f.surface = {{{0, 100}, {50, 100}, {250, 100}, {300, 100}}};
  f.flight = {image(58, 170.55, 0.3),   image(90, 156.55, 0.1),   image(120, 144.55, -0.1),
              image(209, 137.55, -0.9), image(227, 147.55, -1.2), image(244, 156.55, -1.5)};
  f.contact = {image(165, 122.55, -0.35, 60.0), image(180, 120.55, -0.5, 55.0)};
  return f;
}

void same(double expected, const std::optional<double>& actual, double tolerance = 1e-9) {
  CHECK_TRUE(actual.has_value());
  DOUBLES_EQUAL(expected, *actual, tolerance);
}

/// A ball in flight with this spin, seen at this phase of the equator, by the program's rules.
double legacy_spin(double omega, double phase, double period_s) {
  LegacyFrame f = hand_frame();
  f.period_s = period_s;
  for (std::size_t i = 0; i < 3; ++i) {
    const PointPx c = f.flight[i].centre;
    f.flight[i] = image(c.x, c.y, phase + omega * period_s * static_cast<double>(i));
  }
  return *reduce_legacy(f).value[Quantity::omega_td_radps];
}

double share_of_wrong_phases(double omega) {
  constexpr int kPhases = 20000;
  int wrong = 0;
  for (int i = 0; i < kPhases; ++i) {
    const double phase = kHalfTurn * (i + 0.5) / kPhases;
    if (std::abs(legacy_spin(omega, phase, 0.003) - omega) > 10.0) ++wrong;
  }
  return static_cast<double>(wrong) / kPhases;
}

}  // namespace

TEST_GROUP(LegacyProgram){};

TEST(LegacyProgram, GivesTheNumbersWorkedOutByHand) {
  const Readout r = reduce_legacy(hand_frame());
  CHECK_EQUAL("legacy", r.method);
  same(15.0, r.value[Quantity::vx_td_mps]);
  same(-6.0, r.value[Quantity::vy_td_mps]);
  same(9.0, r.value[Quantity::vx_lo_mps]);
  same(5.0, r.value[Quantity::vy_lo_mps]);
  same(5.0 / 6.0, r.value[Quantity::e]);
  same(6.0 / 11.0, r.value[Quantity::mu]);
  same(-0.380506377112365 * 57.3, r.value[Quantity::theta_in_deg]);  // atan(6 / 15), 57.3 to the radian
  same(-100.0, r.value[Quantity::omega_td_radps]);
  same(-150.0, r.value[Quantity::omega_lo_radps]);
  same(9.0 - 0.03255 * 150.0, r.value[Quantity::slip_lo_mps]);
  same(5.0, r.value[Quantity::dwell_time_ms]);
  same(5.0, r.value[Quantity::dwell_distance_cm]);
  CHECK_FALSE(r.sd[Quantity::e].has_value());
  CHECK_FALSE(r.regime.has_value());
}

TEST(LegacyProgram, FarNumbersComeFromTheOuterImages) {
  const Readout r = reduce_legacy(hand_frame());
  CHECK_TRUE(r.legacy.has_value());
  same(16.0, r.legacy->far[Quantity::vx_td_mps]);
  same(-7.0, r.legacy->far[Quantity::vy_td_mps]);
  same(8.5, r.legacy->far[Quantity::vx_lo_mps]);
  same(4.5, r.legacy->far[Quantity::vy_lo_mps]);
  same(4.5 / 7.0, r.legacy->far[Quantity::e]);
  CHECK_FALSE(r.legacy->far[Quantity::dwell_time_ms].has_value());
}

TEST(LegacyProgram, ContactImagesAreFractions) {
  const Readout r = reduce_legacy(hand_frame());
  LONGS_EQUAL(2, r.legacy->contact.size());
  const ContactImage& first = r.legacy->contact[0];
  // Flash 1 in contact is 2 ms after image 3, which is touchdown itself: time fraction 0.
  DOUBLES_EQUAL(0.0, first.time_fraction, 1e-12);
  DOUBLES_EQUAL(15.0 / 50.0, first.x_fraction, 1e-12);
  DOUBLES_EQUAL(2.255, first.height_cm, 1e-12);
  // Top: 122.55 + 30 = 152.55 against 165.1 when it touched down.
  DOUBLES_EQUAL((152.55 - 165.1) / 65.1, first.y_fraction, 1e-12);
  // Angle at touchdown -0.1 - 100 * 2 ms = -0.3; at lift-off -0.9 + 150 * 1 ms = -0.75; total -0.45.
  DOUBLES_EQUAL(0.05 / 0.45, first.rotation_fraction, 1e-12);
  const ContactImage& second = r.legacy->contact[1];
  DOUBLES_EQUAL(0.4, second.time_fraction, 1e-12);
  DOUBLES_EQUAL(0.2 / 0.45, second.rotation_fraction, 1e-12);
}

TEST(LegacyProgram, ContactImagesTurnOnPastTheVertical) {
  // Spin 100 rad/s: the equator is at 1.5 rad in image 3 and at 1.7 at touchdown; 1.8 in contact has the slope of
  // -1.3416 (the program's pi). At lift-off that of 1.85, which the program takes for a turn of -2.9916.
  LegacyFrame f = hand_frame();
  const double angles[] = {1.1, 1.3, 1.5, 2.0, 2.3, 2.6};
  for (std::size_t i = 0; i < 6; ++i)
    f.flight[i] = image(f.flight[i].centre.x, f.flight[i].centre.y, angles[i]);
  f.contact[0] = image(165, 122.55, 1.8, 60.0);
  const double slope_angle = 1.8 - kHalfTurn, lift_off = 2.0 - kHalfTurn - 0.15;
  DOUBLES_EQUAL((slope_angle - 1.7 + 3.1416) / (lift_off - 1.7),
                reduce_legacy(f).legacy->contact[0].rotation_fraction, 1e-9);
  // -0.3 at touchdown and a positive slope in contact: a half turn less; so at lift-off, 1.65.
  f = hand_frame();
  f.contact[0] = image(165, 122.55, 1.2, 60.0);
  f.flight[3] = image(209, 137.55, 1.5), f.flight[4] = image(227, 147.55, 1.2);
  DOUBLES_EQUAL((1.2 + 0.3 - 3.1416) / (1.65 + 0.3 - 3.1416),
                reduce_legacy(f).legacy->contact[0].rotation_fraction, 1e-9);
}

TEST(LegacyProgram, DoublesTheTilt) {
  // A shot of 15.62, -6.71 m/s (-23.25 degrees) photographed with the camera turned by 1 degree reads -21.25.
  LegacyFrame f = hand_frame();
  const double a = kHalfTurn / 180;
  const auto turn = [&](PointPx& p) {
    p = {p.x * std::cos(a) - p.y * std::sin(a), p.x * std::sin(a) + p.y * std::cos(a)};
  };
  for (std::size_t i = 0; i < 3; ++i) {
    f.flight[i] =
        image(120 + (static_cast<double>(i) - 2) * 31.24, 144.55 - (static_cast<double>(i) - 2) * 13.42, 0.0);
  }
  for (PointPx& p : f.surface) turn(p);
  for (LegacyImage& i : f.flight) turn(i.centre), turn(i.edge), turn(i.equator_1), turn(i.equator_2);
  same(-21.25, reduce_legacy(f).value[Quantity::theta_in_deg], 0.01);
}

TEST(LegacyProgram, UnwrapsBackspinWrongAsOftenAsTheErrataSay) {
  // 16 % of equator phases at 165 rad/s, 36 % at 300; topspin never below a quarter turn.
  DOUBLES_EQUAL(0.16, share_of_wrong_phases(165.0), 0.005);
  DOUBLES_EQUAL(0.36, share_of_wrong_phases(300.0), 0.005);
  DOUBLES_EQUAL(0.0, share_of_wrong_phases(-165.0), 1e-9);
}

TEST(LegacyProgram, ReducesADigitizedFrameAsItReducesItsOwn) {
  const LegacyFrame own = hand_frame();
  const Readout direct = reduce_legacy(own);
  const auto by_frame = reduce(frame_from_legacy(own), Estimator::legacy);
  CHECK_TRUE(by_frame.has_value());
  for (const Quantity q : {Quantity::vx_td_mps, Quantity::e, Quantity::mu, Quantity::omega_td_radps,
                           Quantity::dwell_time_ms, Quantity::dwell_distance_cm})
    same(*direct.value[q], by_frame->value[q], 1e-9);
  same(*direct.legacy->far[Quantity::e], by_frame->legacy->far[Quantity::e], 1e-9);
  DOUBLES_EQUAL(direct.legacy->contact[1].x_fraction, by_frame->legacy->contact[1].x_fraction, 1e-9);
}

TEST(LegacyProgram, ReducesTheMirrorImageOfADigitizedFrameAlike) {
  Frame frame = frame_from_legacy(hand_frame());
  frame.record["operator"] = "A";
  frame.images.insert(frame.images.begin() + 5, frame.images[4]);  // a third contact image, of no use to it
  frame.images[5].time_s = 0.010;
  for (BallImage& i : frame.images) i.centre_px.x = -i.centre_px.x, i.equator_rad = -*i.equator_rad;
  for (PointPx& p : frame.surface_px) p.x = -p.x;
  std::swap(frame.surface_px[0], frame.surface_px[2]);
  const Readout direct = reduce_legacy(hand_frame()), mirrored = *reduce(frame, Estimator::legacy);
  CHECK_TRUE(mirrored.mirrored);
  LONGS_EQUAL(41, mirrored.shot_id);
  CHECK_TRUE(mirrored.record == frame.record && mirrored.flags.empty());
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    CHECK_EQUAL(direct.value[q].has_value(), mirrored.value[q].has_value());
    if (direct.value[q]) same(*direct.value[q], mirrored.value[q]);
  }
  LONGS_EQUAL(2, mirrored.legacy->contact.size());
  DOUBLES_EQUAL(direct.legacy->contact[1].rotation_fraction, mirrored.legacy->contact[1].rotation_fraction,
                1e-9);
}

TEST(LegacyProgram, NeedsNeitherContactImagesNorAllEquators) {
  Frame frame = frame_from_legacy(hand_frame());
  frame.images.erase(frame.images.begin() + 3, frame.images.begin() + 5);
  frame.images[1].equator_rad.reset();
  const Readout r = *reduce(frame, Estimator::legacy);  // the median of 2, 2, 8, 2 and 2 ms is its period
  CHECK_TRUE(r.flags.has(Flag::no_contact_image));
  same(15.0, r.value[Quantity::vx_td_mps]);
  same(5.0, r.value[Quantity::dwell_time_ms]);
  CHECK_FALSE(r.value[Quantity::omega_td_radps].has_value());
  LegacyFrame between = hand_frame();  // two flashes: impact and no image of it
  between.contact_count = 0, between.contact.clear();
  same(-1.0, reduce(frame_from_legacy(between), Estimator::legacy)->value[Quantity::dwell_time_ms]);
}

TEST(LegacyProgram, WithoutThreeImagesASideOrFourSurfacePointsItHasNoNumbers) {
  for (const int lacking : {0, 1, 2}) {
    Frame frame = frame_from_legacy(hand_frame());
    if (lacking == 0) frame.images.erase(frame.images.begin());
    if (lacking == 1) frame.images.pop_back();
    if (lacking == 2) frame.surface_px.pop_back();
    frame.record["operator"] = "A";
    const auto r = reduce(frame, Estimator::legacy);
    CHECK_TRUE(r.has_value());
    CHECK_TRUE(r->flags.has(Flag::too_few_images));
    CHECK_FALSE(r->value[Quantity::e].has_value());
    LONGS_EQUAL(41, r->shot_id);
    CHECK_TRUE(r->record == frame.record);
  }
}

TEST(LegacyProgram, LegsInTheWrongOrderAreDegenerate) {
  Frame frame = frame_from_legacy(hand_frame());
  for (BallImage& i : frame.images) {
    if (i.leg != Leg::contact) i.leg = i.leg == Leg::incoming ? Leg::rebound : Leg::incoming;
  }
  const auto r = reduce(frame, Estimator::legacy);
  CHECK_TRUE(r && r->flags.has(Flag::degenerate_geometry));
  CHECK_FALSE(r->value[Quantity::e].has_value());
  frame.surface_px.assign(4, {10, 100});  // nor is there a surface
  CHECK_TRUE(reduce(frame, Estimator::legacy)->flags.has(Flag::degenerate_geometry));
}

TEST_GROUP(LegacyToFrame){};

TEST(LegacyToFrame, PutsImagesAtWholePeriods) {
  const Frame frame = frame_from_legacy(hand_frame());
  LONGS_EQUAL(8, frame.images.size());
  DOUBLES_EQUAL(0.004, frame.images[2].time_s, 1e-15);
  DOUBLES_EQUAL(0.006, frame.images[3].time_s, 1e-15);  // first contact image
  DOUBLES_EQUAL(0.012, frame.images[5].time_s, 1e-15);  // three contact flashes: 3, 4, 5; rebound from 6
  CHECK_EQUAL(Leg::rebound, frame.images[5].leg);
  DOUBLES_EQUAL(65.1, frame.images[0].diameter_px, 1e-12);
  STRCMP_EQUAL("41", frame.record.at("frame_number").c_str());
  LONGS_EQUAL(41, frame.shot_id);
  LONGS_EQUAL(6, *frame.images[5].flash_index);
  LegacyFrame level = hand_frame();
  level.flight[0].equator_2.y = level.flight[0].equator_1.y;  // along x, and along y
  level.flight[1].equator_2.x = level.flight[1].equator_1.x;
  level.flight[2].equator_2 = level.flight[2].equator_1;
  DOUBLES_EQUAL(0.0, *frame_from_legacy(level).images[0].equator_rad, 1e-15);
  DOUBLES_EQUAL(kHalfTurn / 2, *frame_from_legacy(level).images[1].equator_rad, 1e-15);
  CHECK_FALSE(frame_from_legacy(level).images[2].equator_rad.has_value());
}

TEST(LegacyToFrame, TheOtherEstimatorsReadIt) {
  const auto r = reduce(frame_from_legacy(hand_frame()), Estimator::two_point);
  CHECK_TRUE(r.has_value());
  same(15.0, r->value[Quantity::vx_td_mps]);
  same(5.0, r->value[Quantity::dwell_time_ms]);
  CHECK_TRUE(reduce(frame_from_legacy(hand_frame()), Estimator::best).has_value());
}

namespace {

std::string number(double v) { return std::to_string(v); }

void line(std::string& text, PointPx p) { text += number(p.x) + " " + number(p.y) + "\n"; }

std::string file_text(int contact_count, int frame_number) {
  const LegacyFrame f = hand_frame();
  std::string text = std::to_string(contact_count) + " " + std::to_string(frame_number) + "\n";
  for (const PointPx& p : f.surface) line(text, p);
  const auto add = [&](const LegacyImage& i) {
    text += "\n";
    line(text, i.centre), line(text, i.edge), line(text, i.equator_1), line(text, i.equator_2);
  };
  for (const LegacyImage& i : f.flight) add(i);
  add(f.contact[0]);
  if (contact_count != 1) add(f.contact[1]);
  return text;
}

std::string complaint(const std::string& text, std::size_t frame = 0) {
  const auto frames = parse_legacy(text, "old.txt");
  if (frame >= frames.size()) return "no such frame";
  return frames[frame] ? "" : frames[frame].error().message;
}

/// The text with one line (1-based) replaced.
std::string with_line(const std::string& text, int line_number, const std::string& replacement) {
  std::size_t at = 0;
  for (int i = 1; i < line_number; ++i) at = text.find('\n', at) + 1;
  return text.substr(0, at) + replacement + text.substr(text.find('\n', at));
}

}  // namespace

TEST_GROUP(LegacyFile) { std::string two = "0.002\n" + file_text(3, 41) + "\n\n" + file_text(1, 42); };

TEST(LegacyFile, ReadsFramesWithTwoContactImagesAndWithOne) {
  const auto frames = parse_legacy(two, "old.txt");
  LONGS_EQUAL(2, frames.size());
  CHECK_TRUE(frames[0] && frames[1]);
  LONGS_EQUAL(41, frames[0]->frame_number);
  LONGS_EQUAL(2, frames[0]->contact.size());
  LONGS_EQUAL(1, frames[1]->contact.size());
  LONGS_EQUAL(1, frames[1]->contact_count);
  DOUBLES_EQUAL(0.002, frames[1]->period_s, 0.0);
  DOUBLES_EQUAL(227.0, frames[0]->flight[4].centre.x, 0.0);
  same(15.0, reduce_legacy(*frames[0]).value[Quantity::vx_td_mps], 1e-6);  // six decimals in the file
}

TEST(LegacyFile, LineEndsAndBlanksDoNotMatter) {
  std::string dos;
  for (const char c : two) dos += c == '\n' ? std::string(" \t\r\n") : std::string(1, c);
  const auto frames = parse_legacy(dos + "\r\n\r\n\r\n", "old.txt");
  LONGS_EQUAL(2, frames.size());
  CHECK_TRUE(frames[0] && frames[1]);
}

TEST(LegacyFile, NamesFileAndLineOfWhatIsWrong) {
  CHECK_EQUAL("old.txt:1: must be the strobe period in seconds, above 0 and at most 1", complaint("fast\n"));
  STRCMP_CONTAINS("old.txt:1: must be the strobe period", complaint(with_line(two, 1, "-0.002")).c_str());
  STRCMP_CONTAINS("old.txt:1: must be the strobe period", complaint(with_line(two, 1, "nan")).c_str());
  STRCMP_EQUAL("old.txt:2: must be two whole numbers: contact count, frame number",
               complaint(with_line(two, 2, "3")).c_str());
  STRCMP_EQUAL("old.txt:2: the contact count must be from 1 to 1000",
               complaint(with_line(two, 2, "0 41")).c_str());
  for (const char* period : {"0", "1.001", "0.002 1"})
    STRCMP_CONTAINS("old.txt:1: must be the strobe period", complaint(with_line(two, 1, period)).c_str());
  STRCMP_EQUAL("", complaint(with_line(two, 1, "+1")).c_str());
  STRCMP_CONTAINS("old.txt:2: must be two whole", complaint(with_line(two, 2, "3 41 7")).c_str());
  STRCMP_EQUAL("", complaint(with_line(two, 2, "1000 41")).c_str());
  STRCMP_CONTAINS("old.txt:2: the contact count", complaint(with_line(two, 2, "1001 41")).c_str());
  STRCMP_EQUAL("old.txt:9: the edge point of image 1 is its centre",
               complaint(with_line(two, 9, "58 170.55")).c_str());
  STRCMP_EQUAL("old.txt:11: the equator points of image 1 are one point",
               complaint(with_line(with_line(two, 10, "1 2"), 11, "1 2")).c_str());
  STRCMP_EQUAL("old.txt:4: surface point 2 must be two finite numbers",
               complaint(with_line(two, 4, "50 x")).c_str());
  STRCMP_EQUAL("old.txt:4: surface point 2 must be two finite numbers",
               complaint(with_line(two, 4, "50 nan")).c_str());
  STRCMP_EQUAL("old.txt:4: surface point 2 must be two finite numbers",
               complaint(with_line(two, 4, "50 1 2")).c_str());
  STRCMP_EQUAL("old.txt:8: centre of image 1 must be two finite numbers",
               complaint(with_line(two, 8, "58,0 170")).c_str());
  STRCMP_EQUAL("old.txt:7: a blank line must come before image 1",
               complaint(with_line(two, 7, "1 2")).c_str());
}

TEST(LegacyFile, ABadFrameDoesNotHideTheNext) {
  const auto frames = parse_legacy(with_line(two, 20, "bad"), "old.txt");
  LONGS_EQUAL(2, frames.size());
  CHECK_FALSE(frames[0].has_value());
  CHECK_TRUE(frames[1].has_value());
}

TEST(LegacyFile, ATruncatedFrameSaysWhereItEnds) {
  STRCMP_EQUAL("old.txt:47: the frame has more lines than 8 images",
               complaint(with_line(two, 46, "1 2\n3 4")).c_str());
  const std::string cut = two.substr(0, two.size() - 30);
  STRCMP_CONTAINS("old.txt:", complaint(cut, 1).c_str());
  const std::string one = "0.002\n3 41\n1 2\n3 4\n";
  CHECK_EQUAL("old.txt:4: the frame ends where surface point 3 should follow", complaint(one));
  STRCMP_CONTAINS("no frame follows", complaint("0.002\n\n\n").c_str());
  STRCMP_CONTAINS("the file is empty", complaint("").c_str());
}
