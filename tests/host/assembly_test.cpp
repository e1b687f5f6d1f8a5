// Images to flashes and on to the readout, against shots whose truth is known. What is never allowed: a wrong
// number that no flag tells of.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <map>
#include <random>
#include <string>

#include "host/assembly/assemble.hpp"
#include "host/session/shot.hpp"
#include "tests/host/synthetic_shot.hpp"
#include "tests/support/recorded.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using namespace strobe::host_test;
using host::AssembledShot;
using reduction::Flag;
using reduction::Quantity;
using reduction::Readout;

host::AssemblySettings settings() {
  host::AssemblySettings s;
  s.machine_lag_s = kMachineLag_s;
  s.ball.fastest_spin_radps = 600.0;
  return s;
}

AssembledShot assembled(const SyntheticShot& made) {
  return host::assemble(made.shot, made.frame, settings());
}
Readout readout(const SyntheticShot& made) {
  return host::shot_readout(made.shot, made.frame, settings()).readout;
}

std::string flags_of(const reduction::FlagSet& flags) {
  std::string text;
  for (std::size_t i = 0; i < reduction::kFlagCount; ++i)
    if (flags.has(static_cast<Flag>(i))) text += std::string(reduction::kFlagNames[i]) + " ";
  return text;
}

std::map<Quantity, double> truth(const Bounce& b) {
  return {{Quantity::vx_td_mps, b.vx_td},
          {Quantity::vy_td_mps, b.vy_td},
          {Quantity::vx_lo_mps, b.vx_lo},
          {Quantity::vy_lo_mps, b.vy_lo},
          {Quantity::e, -b.vy_lo / b.vy_td},
          {Quantity::mu, (b.vx_td - b.vx_lo) / (b.vy_lo - b.vy_td)},
          {Quantity::dwell_time_ms, b.dwell_s * 1e3},
          {Quantity::dwell_distance_cm, b.distance_m * 1e2}};
}

/// Largest |estimate - truth| / sd. The bounce has no drag, so the estimator must assume none: the
/// bias that its drag brings is below a tenth of these sds.
double worst_z(const Readout& r, const Bounce& b) {
  double worst = 0.0;
  for (const auto& [quantity, value] : truth(b)) {
    if (!r.value[quantity] || !r.sd[quantity]) return 1e9;
    worst = std::max(worst, std::abs(*r.value[quantity] - value) / *r.sd[quantity]);
  }
  return worst;
}

// Of 8 numbers in some 1,000 shots one beyond 5 sd is expected once in 200 runs; seeds are fixed.
constexpr double kMaxZ = 5.0;

std::vector<int> flashes_of(const AssembledShot& shot) {
  std::vector<int> flashes;
  for (const auto& image : shot.frame.images) flashes.push_back(image.flash_index.value_or(-1));
  return flashes;
}

Bounce steep() { return {6.57, -14.9, 3.0, 2.74, 10.3, -90.0, 3.9e-3, 0.0161}; }
Bounce shallow() { return {15.62, -4.81, -5.3, 11.09, 4.22, -239.0, 6.02e-3, 0.0784}; }

/// What is read of shots in which one flash, counted from the last before touchdown, is not as the others. No number
/// is wrong without a flag.
template <typename Change>
std::vector<Readout> readouts_with_faults(int first_offset, int last_offset, std::uint32_t seeds,
                                          const Change& change) {
  std::vector<Readout> readouts;
  for (int offset = first_offset; offset <= last_offset; ++offset) {
    for (std::uint32_t seed = 1; seed <= seeds; ++seed) {
      Scenario sc;
      sc.seed = seed;
      const int k = last_flash_before_touchdown(sc) + offset;
      change(sc, k);
      const SyntheticShot made = make_shot(sc);
      const bool in_view = made.image_flash.front() <= k && k <= made.image_flash.back();
      if (sc.late_us.contains(k) && !in_view) continue;
      const Readout& r = readouts.emplace_back(readout(made));
      const double z = worst_z(r, sc.bounce);
      CHECK_TEXT(z < kMaxZ || r.flags.has(Flag::flash_match_ambiguous),
                 fmt::format("flash {} from touchdown, seed {}: {} z {}", offset, seed, flags_of(r.flags), z)
                     .c_str());
    }
  }
  return readouts;
}

}  // namespace

TEST_GROUP(Assembly){};

TEST(Assembly, ACleanShotGetsItsFlashesAndNoFlag) {
  for (const Bounce& bounce : {Bounce{}, steep(), shallow()}) {
    Scenario sc;
    sc.bounce = bounce;
    const SyntheticShot made = make_shot(sc);
    const AssembledShot shot = assembled(made);
    CHECK_EQUAL("", flags_of(shot.flags));
    CHECK_EQUAL(made.image_flash, flashes_of(shot));
    DOUBLES_EQUAL(0.0, shot.frame.images.front().time_s, 0.0);
    const double z = worst_z(readout(made), bounce);
    CHECK_TEXT(z < kMaxZ, fmt::format("z {}", z).c_str());
  }
}

TEST(Assembly, TheFrameKnowsTheBallAsTheRigFileDoes) {
  const SyntheticShot made = make_shot({});
  CHECK_FALSE(assembled(made).frame.ball_mass_kg.has_value());
  CHECK_FALSE(assembled(made).frame.ball_alpha.has_value());
  host::AssemblySettings heavy = settings();
  heavy.ball.diameter_m = 0.0660;
  heavy.ball.mass_kg = 0.0585;
  heavy.ball.alpha = 0.6;
  heavy.ball.alpha_sd = 0.01;
  heavy.ball.fastest_spin_radps = 500.0;
  const reduction::Frame frame = host::assemble(made.shot, made.frame, heavy).frame;
  DOUBLES_EQUAL(0.0660, frame.ball_diameter_m, 0.0);
  DOUBLES_EQUAL(500.0, frame.fastest_spin_radps.value(), 0.0);
  DOUBLES_EQUAL(0.0585, frame.ball_mass_kg.value(), 0.0);
  DOUBLES_EQUAL(0.6, frame.ball_alpha.value(), 0.0);
  DOUBLES_EQUAL(0.01, frame.ball_alpha_sd.value(), 0.0);
}

TEST(Assembly, AnOffsetThatCannotBeToldApartDoesNotMatter) {
  Scenario sc;
  sc.machine_error_s = 0.020;  // the arrival is expected seven flashes off
  const SyntheticShot made = make_shot(sc);
  const AssembledShot shot = assembled(made);
  CHECK_EQUAL("", flags_of(shot.flags));
  CHECK(worst_z(readout(made), sc.bounce) < kMaxZ);
}

TEST(Assembly, ABallToTheLeftIsMatchedAsWell) {
  Scenario sc;
  sc.leftwards = true;
  const SyntheticShot made = make_shot(sc);
  CHECK_EQUAL(made.image_flash, flashes_of(assembled(made)));
  const Readout r = readout(made);
  CHECK_TRUE(r.mirrored);
  CHECK(worst_z(r, sc.bounce) < kMaxZ);
}

TEST(Assembly, LegsThatNobodyNamedAreFound) {
  for (const Bounce& bounce : {Bounce{}, steep(), shallow()}) {
    Scenario sc;
    sc.bounce = bounce;
    sc.legs_named = false;
    const SyntheticShot made = make_shot(sc);
    CHECK_EQUAL(made.image_flash, flashes_of(assembled(made)));
  }
}

TEST(Assembly, ALateFlashAtAnyPlaceGivesRightNumbersAndIsFlagged) {
  int ambiguous = 0;
  for (const Readout& r : readouts_with_faults(-5, 8, 20, [](Scenario&sc, int k) { sc.late_us[k] = 160; })) {
    ambiguous += r.flags.has(Flag::flash_match_ambiguous);
    CHECK_TEXT(r.flags.has(Flag::late_flash) || r.flags.has(Flag::flash_match_ambiguous),
               flags_of(r.flags).c_str());
  }
  // With five or more images a leg and 0.2 mm of noise a flash 2.5 mm off its place is seldom mistaken.
  CHECK_TEXT(ambiguous <= 3, fmt::format("{} of 280 ambiguous", ambiguous).c_str());
}

TEST(Assembly, AnAssumedPunctualFlashWouldBeWrong) {
  // The reason for measuring: the same photograph with the flash times as commanded.
  Scenario sc;
  sc.view_before_m = 0.12;
  const int k = last_flash_before_touchdown(sc);
  sc.late_us[k] = 160;
  SyntheticShot made = make_shot(sc);
  for (auto& flash : made.shot.flashes)
    flash.observed_a_ns = flash.observed_b_ns = flash.commanded_ns + 12'000;
  CHECK(worst_z(readout(made), sc.bounce) > 5.0);
}

TEST(Assembly, AMissingFlashAtAnyPlaceMakesNoImageAndIsFlagged) {
  for (const Readout& r : readouts_with_faults(-3, 6, 10, [](Scenario&sc, int k) { sc.missing.insert(k); }))
    CHECK_TEXT(r.flags.has(Flag::missing_flash) || r.flags.has(Flag::flash_match_ambiguous),
               flags_of(r.flags).c_str());
}

TEST(Assembly, ADoubleFlashAmongThoseThatShowTheBallIsFlaggedAndAnotherIsNot) {
  Scenario sc;
  sc.doubled.insert(last_flash_before_touchdown(sc) - 1);
  CHECK_TRUE(readout(make_shot(sc)).flags.has(Flag::double_flash));
  sc.doubled = {3, 160};
  CHECK_FALSE(readout(make_shot(sc)).flags.has(Flag::double_flash));
}

TEST(Assembly, FaultsAmongFlashesThatDoNotShowTheBallAreNobodysBusiness) {
  Scenario sc;
  sc.late_us[20] = 160;
  sc.late_us[140] = 500;
  sc.missing = {10, 150};
  CHECK_EQUAL("", flags_of(readout(make_shot(sc)).flags));
}

TEST(Assembly, AnImageThatNobodySawIsADoubleStepNotAMissingFlash) {
  for (const Readout& r : readouts_with_faults(-3, 6, 10, [](Scenario&sc, int k) { sc.unseen.insert(k); }))
    CHECK_FALSE_TEXT(r.flags.has(Flag::missing_flash), flags_of(r.flags).c_str());
}

TEST(Assembly, UnequalIntervalsPinTheOffsetWhateverTheMachineDid) {
  // Lateness drawn over 0.6 ms moves an image by up to 10 mm, 50 times the noise.
  for (const double machine_error_s : {-0.05, 0.0, 0.08}) {
    Scenario sc;
    sc.machine_error_s = machine_error_s;
    std::mt19937 generator(7);
    std::uniform_real_distribution<double> lateness_us(0.0, 600.0);
    for (int k = 0; k < sc.flash_count; ++k) sc.late_us[k] = lateness_us(generator);
    const SyntheticShot made = make_shot(sc);
    CHECK_EQUAL(made.image_flash, flashes_of(assembled(made)));
    CHECK(worst_z(readout(made), sc.bounce) < kMaxZ);
  }
}

/// Beside the first image in contact, three of the model's sds off, one that is no ball's.
SyntheticShot with_another_in_contact(double probability) {
  SyntheticShot made = make_shot({});
  auto& images = made.frame.images;
  for (auto& image : images) image.probability = 0.999;
  const auto contact = std::ranges::find(images, strobe_msgs::ball_image_t::LEG_CONTACT,
                                         &strobe_msgs::ball_image_t::leg);
  CHECK_TRUE(contact != images.end());
  auto another = *contact;
  another.probability = probability;
  another.centre_x_px += 0.15 * another.diameter_px;
  images.insert(contact + 1, another);
  made.frame.image_count = static_cast<std::int32_t>(images.size());
  return made;
}

TEST(Assembly, ADoubtfulImageInContactThatNoFlashMadeIsLeftOutAndTheTimesStay) {
  const SyntheticShot made = with_another_in_contact(0.3);
  const AssembledShot shot = assembled(made);
  CHECK_EQUAL("", flags_of(shot.flags));  // the frame said itself that it is rather none
  CHECK_EQUAL(made.image_flash, flashes_of(shot));
  CHECK(worst_z(readout(made), {}) < kMaxZ);
}

TEST(Assembly, AnImageInContactThatContradictsAllOthersIsFlaggedThoughItLooksLikeTheBall) {
  const SyntheticShot made = with_another_in_contact(0.7);
  const AssembledShot shot = assembled(made);
  CHECK_EQUAL(made.image_flash, flashes_of(shot));
  CHECK_EQUAL("outlier_image ", flags_of(shot.flags));
}

TEST(Assembly, AGapThatContactDoesNotDecideIsAmbiguous) {
  // Straight down: neither the way along the surface nor a contact image tells one flash from two in contact.
  Scenario sc;
  sc.bounce = {0.4, -8.0, 0.0, 0.3, 6.4, -5.0, 4.0e-3, 0.0014};
  const int k = last_flash_before_touchdown(sc);
  sc.unseen = {k + 1};
  sc.touchdown_s = k * sc.period_s + 1.4e-3;
  sc.bounce.dwell_s = 2.4e-3;
  const SyntheticShot made = make_shot(sc);
  const Readout r = readout(made);
  const bool right = worst_z(r, sc.bounce) < kMaxZ;
  CHECK_TRUE(r.flags.has(Flag::flash_match_ambiguous) || right);
}

TEST(Assembly, ADeadSensorLeavesTheOthersTimes) {
  Scenario sc;
  sc.sensor_a = false;
  const Readout r = readout(make_shot(sc));
  CHECK_EQUAL("sensor_missing ", flags_of(r.flags));
  CHECK(worst_z(r, sc.bounce) < kMaxZ);
}

TEST(Assembly, WithoutAnySensorTheTimesAreSaidToBeUncertain) {
  Scenario sc;
  sc.sensor_a = sc.sensor_b = false;
  const SyntheticShot made = make_shot(sc);
  const AssembledShot shot = assembled(made);
  CHECK_TRUE(shot.flags.has(Flag::sensor_missing));
  DOUBLES_EQUAL(20e-6, *shot.frame.images[2].time_sd_s, 1e-12);
  CHECK(worst_z(readout(made), sc.bounce) < kMaxZ);
}

TEST(Assembly, NoiseThatIsNotStatedIsFoundFromTheImages) {
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    Scenario sc;
    sc.seed = seed;
    sc.noise_stated = false;
    sc.late_us[last_flash_before_touchdown(sc) - 1] = 400;
    const Readout r = readout(make_shot(sc));
    CHECK_TRUE(r.flags.has(Flag::late_flash) || r.flags.has(Flag::flash_match_ambiguous));
    CHECK(worst_z(r, sc.bounce) < 8.0);  // Student's t of few degrees of freedom has long tails
  }
}

TEST(Assembly, AnEmptyPhotographHasNoNumbers) {
  Scenario sc;
  SyntheticShot made = make_shot(sc);
  made.frame.images.clear();
  made.frame.image_count = 0;
  const auto result = host::shot_readout(made.shot, made.frame, settings());
  CHECK_TRUE(result.readout.flags.has(Flag::too_few_images));
  CHECK_EQUAL("no image of the ball on the photograph whose leg could be told", result.problem);
  CHECK_FALSE(result.readout.value[Quantity::e].has_value());
}

TEST(Assembly, MoreImagesThanFlashesAreNoShotOfThis) {
  Scenario sc;
  SyntheticShot made = make_shot(sc);
  made.shot.flashes.resize(4);
  const Readout r = readout(made);
  CHECK_TRUE(r.flags.has(Flag::flash_match_ambiguous));
  CHECK_FALSE(r.value[Quantity::vx_td_mps].has_value());
}

TEST(Assembly, AFrameWithoutASurfaceHasNoNumbers) {
  Scenario sc;
  SyntheticShot made = make_shot(sc);
  made.frame.surface.clear();
  made.frame.surface_count = 0;
  CHECK_TRUE(readout(made).flags.has(Flag::degenerate_geometry));
}

TEST(Assembly, AnAbortedShotThatStillShowsTheBallIsComputedAndFlagged) {
  Scenario sc;
  SyntheticShot made = make_shot(sc);
  made.shot.aborted = true;
  made.shot.abort_reason = "the e-stop was pressed";
  const Readout r = readout(made);
  CHECK_TRUE(r.flags.has(Flag::shot_aborted));
  CHECK(worst_z(r, sc.bounce) < kMaxZ);
}

TEST(Assembly, EventsLostBeforeTheJournalAreFlagged) {
  SyntheticShot made = make_shot({});
  made.shot.kernel_overflows = 1;
  CHECK_TRUE(readout(made).flags.has(Flag::events_missing));
}

TEST(Assembly, TheRecordComesWithTheShotAndGivesTheTemperature) {
  SyntheticShot made = make_shot({});
  for (const auto& [key, value] : {std::pair{"temperature_c", "23"}, std::pair{"operator", "A. Author"}}) {
    strobe_msgs::note_t note;
    note.key = key;
    note.value = value;
    made.shot.notes.push_back(note);
  }
  made.shot.note_count = 2;
  DOUBLES_EQUAL(23.0, *assembled(made).frame.temperature_c, 0.0);
  CHECK_EQUAL("A. Author", readout(made).record.at("operator"));
  CHECK_TRUE(readout(made).value[Quantity::court_pace].has_value());
}

// What the tolerances of these tests let pass: per mille and us. Rounding changes them by less than 1e-6.
TEST(Assembly, GivesTheNumbersOnRecord) {
  std::string found;
  const auto add = [&found](const char* name, const SyntheticShot& made, const host::AssemblySettings& s) {
    const AssembledShot shot = host::assemble(made.shot, made.frame, s);
    found += fmt::format("# {}\nflags {}problem {}\nassignments {}", name, flags_of(shot.flags), shot.problem,
                         shot.hypotheses.size());
    if (shot.flashes)
      found += fmt::format(" misassigned {:.6f}", 1e3 * shot.flashes->misassignment_probability);
    for (const auto& image : shot.frame.images) found += fmt::format(" {}", image.flash_index.value_or(-1));
    if (!shot.frame.images.empty())
      found += fmt::format(" until {:.6f}", 1e6 * shot.frame.images.back().time_s);
    found += "\n";
  };
  for (const double noise_mm : {0.2, 1.0}) {
    for (const Bounce& bounce : {Bounce{}, steep(), shallow()}) {
      for (const bool gated : {false, true}) {
        Scenario sc;
        sc.bounce = bounce;
        sc.noise_mm = noise_mm;
        sc.noise_stated = !gated;
        sc.leftwards = gated;
        sc.legs_named = !gated;
        sc.machine_error_s = 0.004;
        sc.unseen = {last_flash_before_touchdown(sc)};
        SyntheticShot made = make_shot(sc);
        if (noise_mm > 0.5) made.frame.centre_sd_px *= 3.0;  // larger than it is
        host::AssemblySettings s = settings();
        s.analysis.surface_angle_deg = gated ? 30.0 : 0.0;
        if (gated) {
          made.shot.gate_ns = made.shot.trigger_ns + 250'000'000;
          s.analysis.gate_distance_m = 1.0;
        }
        add(fmt::format("noise {} mm, gated {}, vy {}", noise_mm, gated, bounce.vy_td).c_str(), made, s);
      }
    }
  }
  Scenario one_leg;
  one_leg.view_after_m = -0.1;
  add("no rebound", make_shot(one_leg), settings());
  one_leg.view_after_m = 0.25;
  one_leg.view_before_m = -0.001;
  add("no incoming leg", make_shot(one_leg), settings());
  Scenario coded;
  coded.intervals_s = {3e-3, 3.4e-3, 3e-3, 2.7e-3};
  coded.omitted = {70, 84};
  coded.noise_mm = 0.6;
  add("coded", make_shot(coded), settings());
  STRCMP_EQUAL("", strobe::testing::difference_from_record("assembly", found, 1e-5).c_str());
}

TEST_GROUP(AssemblyOverManyShots){};

TEST(AssemblyOverManyShots, RandomFaultsNeverGiveAWrongNumberThatNoFlagTellsOf) {
  std::mt19937 generator(20240117);
  const auto pick = [&](int least, int most) {
    return std::uniform_int_distribution<int>(least, most)(generator);
  };
  int ambiguous = 0, repeated = 0, shots = 0;
  for (int i = 0; i < 600; ++i) {
    Scenario sc;
    sc.seed = static_cast<std::uint32_t>(i + 1000);
    sc.bounce = std::array{Bounce{}, steep(), shallow()}[static_cast<std::size_t>(i % 3)];
    sc.touchdown_s = 0.25 + 1e-5 * pick(0, 300);
    sc.machine_error_s = 1e-3 * pick(-8, 8);
    sc.noise_mm = 0.1 * pick(1, 4);
    const int around = last_flash_before_touchdown(sc);
    for (int n = pick(0, 2); n > 0; --n) sc.late_us[around + pick(-12, 14)] = pick(100, 1400);
    for (int n = pick(0, 1); n > 0; --n) sc.missing.insert(around + pick(-12, 14));
    if (pick(0, 3) == 0) sc.unseen.insert(around + pick(-4, 6));
    const Readout r = readout(make_shot(sc));
    ++shots;
    repeated += r.flags.has(Flag::flash_match_ambiguous) && host::rejection_reason(r).has_value() ? 1 : 0;
    if (r.flags.has(Flag::flash_match_ambiguous)) {
      ++ambiguous;
      continue;
    }
    const double z = worst_z(r, sc.bounce);
    CHECK_TEXT(z < kMaxZ || r.flags.has(Flag::too_few_images) || r.flags.has(Flag::outlier_image),
               fmt::format("shot {} (noise {} mm): z {}, {}", i, sc.noise_mm, z, flags_of(r.flags)).c_str());
  }
  // One to four faults about the contact in most of these shots: both must stay the exception all the same.
  CHECK_TEXT(ambiguous < shots / 10, fmt::format("{} of {} ambiguous", ambiguous, shots).c_str());
  CHECK_TEXT(repeated < shots / 10, fmt::format("{} of {} fired again", repeated, shots).c_str());
}
