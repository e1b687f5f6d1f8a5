#include "sim/rig/truth.hpp"

#include <nlohmann/json.hpp>

#include "sim/rig/tablet.hpp"
#include "tests/sim/rig/virtual_rig_fixture.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::sim;

TEST_GROUP(TruthLine) {
  Scene scene = test::plain_scene();

  nlohmann::json line_of(const Exposure& exposure, int shot_id) {
    const std::string text = truth_line(scene, exposure, shot_id);
    LONGS_EQUAL(std::string::npos, text.find('\n'));
    return nlohmann::json::parse(text);
  }
};

TEST(TruthLine, NamesEveryQuantityOfAReadout) {
  test::VirtualRigFixture fixture(scene);
  const auto line = line_of(fixture.shoot(), 7);
  LONGS_EQUAL(1, line["shot"].get<int>());
  LONGS_EQUAL(7, line["shot_id"].get<int>());
  CHECK(line["ball"].get<bool>());
  for (const auto name : reduction::kQuantityNames) CHECK(line["readout"][std::string(name)].is_number());
  CHECK(!line["overrun"].get<bool>());
}

TEST(TruthLine, PlacesLiftOffTheDwellTimeAfterTouchdown) {
  test::VirtualRigFixture fixture(scene);
  const auto line = line_of(fixture.shoot(), 7);
  // 5 ms, and by the ball's weight up to .2 % more (contact_path.hpp).
  const auto dwell_ns = line["liftoff_ns"].get<std::int64_t>() - line["touchdown_ns"].get<std::int64_t>();
  CHECK(dwell_ns > 5'000'000 && dwell_ns < 5'010'000);
}

TEST(TruthLine, SaysWhichFlashMadeEachImageAndWhen) {
  test::VirtualRigFixture fixture(scene);
  const Exposure exposure = fixture.shoot();
  const auto line = line_of(exposure, 7);
  LONGS_EQUAL(exposure.pulses.size(), line["flash_true_ns"].size());
  const auto image_flash = line["image_flash"].get<std::vector<int>>();
  LONGS_EQUAL(digitize(scene, 1, exposure).frame.images.size(), image_flash.size());
  // The first image that touches is the first flash within the dwell time.
  const auto touchdown = line["touchdown_ns"].get<std::int64_t>();
  for (const int flash : image_flash)
    CHECK(std::abs(line["flash_true_ns"][static_cast<std::size_t>(flash)].get<std::int64_t>() - touchdown) <
          60'000'000);
}

TEST(TruthLine, HasNoReadoutWithoutABall) {
  test::VirtualRigFixture fixture(scene);
  const auto line = line_of(fixture.shoot({.throw_ball = false}), 7);
  CHECK(!line["ball"].get<bool>());
  CHECK(line["readout"].is_null());
  CHECK(line["touchdown_ns"].is_null());
  LONGS_EQUAL(0, line["image_flash"].size());
}

TEST(TruthLine, TellsAFlashThatWasNone) {
  scene.faults = {{.kind = FaultKind::flash_missing, .flash_index = 3}};
  test::VirtualRigFixture fixture(scene);
  const auto line = line_of(fixture.shoot(), 7);
  CHECK(line["flash_true_ns"][3].is_null());
  CHECK(line["flash_true_ns"][4].is_number());
  CHECK_EQUAL("[\"flash_missing\"]", line["faults"].dump());
}
