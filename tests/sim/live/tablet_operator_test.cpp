#include "sim/live/tablet_operator.hpp"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "common/messages/channels.hpp"
#include "common/wire/lcm_url.hpp"
#include "tests/sim/rig/virtual_rig_fixture.hpp"
#include "tests/support/json_lines.hpp"
#include "tests/support/private_network.hpp"
#include "tests/support/sealed_sender.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using namespace strobe::sim;

constexpr std::int64_t kBoot = 0x1234567890;
constexpr int kFrameLimit_ms = 10000;  // far longer than it takes, so that a busy machine does not fail
constexpr int kSilence_ms = 400;       // many of the desk's rounds

/// A host's ear and a firmware's mouth.
class Listener {
 public:
  Listener(const std::string& url, const authentication::Key& key) : lcm_(url), lab_(key), seal_(key) {
    lcm_.subscribe(messages::channel_name("bench", messages::Channel::frame), &Listener::on_frame, this);
  }
  void announce(int shot_id, MonoTime start, bool sealed = true) {
    strobe_msgs::shot_t shot{};
    shot.schema_version = strobe_msgs::shot_t::SCHEMA_VERSION;
    shot.boot_id = kBoot;
    shot.shot_id = shot_id;
    shot.start_ns = to_ns(start);
    const std::string channel = messages::channel_name("bench", messages::Channel::shot);
    const auto packet = sealed ? lab_.packet(channel, shot) : messages::encode(shot);
    lcm_.publish(channel, packet.data(), static_cast<unsigned>(packet.size()));
  }
  /// Waits for so many frames in all, or until the limit.
  bool hear(std::size_t frames, int limit_ms) {
    const MonoTime end = RigClock{}.now() + milliseconds(limit_ms);
    while (frames_.size() < frames && RigClock{}.now() < end) lcm_.handleTimeout(10);
    return frames_.size() >= frames;
  }
  const std::vector<strobe_msgs::frame_t>& frames() const { return frames_; }

 private:
  void on_frame(const lcm::ReceiveBuffer* buffer, const std::string& channel,
                const strobe_msgs::frame_t* frame) {
    if (seal_.open(channel, {static_cast<const std::uint8_t*>(buffer->data), buffer->data_size}))
      frames_.push_back(*frame);
  }
  lcm::LCM lcm_;
  strobe::testing::SealedSender lab_;
  authentication::PacketSeal seal_;
  std::vector<strobe_msgs::frame_t> frames_;
};

/// The exposure of a shot that ended just now, so that its times are those of the clock.
Exposure exposure_now(const Scene& scene, bool opened = true, bool ball = true) {
  test::VirtualRigFixture fixture(scene);
  Exposure exposure = fixture.shoot({.throw_ball = ball});
  const Duration shift = RigClock{}.now() - exposure.closed - milliseconds(20);
  exposure.line_on = exposure.line_on + shift;
  exposure.opened = opened ? exposure.opened + shift : kNoTime;
  exposure.closed = exposure.closed + shift;
  if (exposure.ball) exposure.ball->touchdown = exposure.ball->touchdown + shift;
  for (Pulse& pulse : exposure.pulses) {
    pulse.edge = pulse.edge + shift;
    for (MonoTime& flash : pulse.flashes) flash = flash + shift;
  }
  return exposure;
}

}  // namespace

TEST_GROUP(TabletOperator) {
  Scene scene = test::plain_scene();
  strobe::testing::TemporaryFolder folder;
  std::string url = strobe::testing::private_lcm_url();
  authentication::Key key = authentication::Key::random();
  ExposureStore exposure_store;
  std::unique_ptr<TruthFile> truth;
  std::unique_ptr<TabletOperator> desk;
  std::unique_ptr<Listener> listener;

  /// A part of 32 bytes at offset 0xfffffff0 of a message of 64: LCM's receiver writes it outside.
  void send_what_harms_lcm() const {
    const auto group = wire::read_lcm_url(url)->group;
    const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(group.port);
    inet_pton(AF_INET, group.address.c_str(), &address.sin_addr);
    std::vector<std::uint8_t> first{'L', 'C', '0', '3', 0, 0, 0, 9, 0, 0, 0, 64, 0, 0, 0, 0, 0, 0, 0, 3};
    std::vector<std::uint8_t> second{'L', 'C', '0',  '3',  0,    0,    0, 9, 0, 0,
                                     0,   64,  0xff, 0xff, 0xff, 0xf0, 0, 1, 0, 3};
    const std::string channel = messages::channel_name("bench", messages::Channel::shot);
    first.insert(first.end(), channel.c_str(), channel.c_str() + channel.size() + 1);
    for (auto* part : {&first, &second}) {
      part->resize(part->size() + 32);
      CHECK(sendto(fd, part->data(), part->size(), 0, reinterpret_cast<const sockaddr*>(&address),
                   sizeof address) > 0);
    }
    close(fd);
  }
  void sit_down(bool attacked = false) {
    scene.tablet.digitize_delay_s = 0.05;
    truth = *TruthFile::create(folder / "truth.jsonl", scene);
    auto made = TabletOperator::create(url, "bench", key, scene, 1, exposure_store, *truth);
    CHECK_TEXT(made.has_value(), made ? "" : made.error().message.c_str());
    desk = std::move(*made);
    desk->start();
    if (attacked) send_what_harms_lcm();  // before the listener, which has LCM's receiver
    listener = std::make_unique<Listener>(url, key);
  }
  std::vector<nlohmann::json> truths() const {
    return strobe::testing::read_json_lines(folder / "truth.jsonl");
  }
};

TEST(TabletOperator, SendsTheFrameOfTheShotThatWasAnnounced) {
  sit_down();
  const Exposure exposure = exposure_now(scene);
  exposure_store.add(exposure);
  listener->announce(7, exposure.line_on - milliseconds(20));
  CHECK(listener->hear(1, kFrameLimit_ms));
  const strobe_msgs::frame_t& frame = listener->frames()[0];
  CHECK_EQUAL(kBoot, frame.boot_id);
  LONGS_EQUAL(7, frame.shot_id);
  LONGS_EQUAL(4, frame.surface_count);
  LONGS_EQUAL(digitize(scene, 1, exposure).frame.images.size(), frame.image_count);
  CHECK_EQUAL("hand", frame.source);
  LONGS_EQUAL(1, truths().size());
  LONGS_EQUAL(7, truths()[0]["shot_id"].get<int>());
}

TEST(TabletOperator, SendsTheSameFrameAgainWhenTheShotIsAnnouncedAgain) {
  scene.tablet.centre_sd_m = 0.3e-3;
  sit_down();
  const Exposure exposure = exposure_now(scene);
  exposure_store.add(exposure);
  listener->announce(1, exposure.line_on);
  CHECK(listener->hear(1, kFrameLimit_ms));
  listener->announce(1, exposure.line_on);
  CHECK(listener->hear(2, kFrameLimit_ms));
  DOUBLES_EQUAL(listener->frames()[0].images[0].centre_x_px, listener->frames()[1].images[0].centre_x_px,
                0.0);
  LONGS_EQUAL(1, truths().size());
}

TEST(TabletOperator, IsNotHarmedByDatagramsThatHarmLcm) {
  sit_down(true);
  const Exposure exposure = exposure_now(scene);
  exposure_store.add(exposure);
  listener->announce(7, exposure.line_on);
  CHECK(listener->hear(1, kFrameLimit_ms));
}

TEST(TabletOperator, BelievesNoAnnouncementWithoutItsSeal) {
  sit_down();
  const Exposure exposure = exposure_now(scene);
  exposure_store.add(exposure);
  listener->announce(8, exposure.line_on, false);
  listener->announce(7, exposure.line_on);  // in order, so that nothing comes of the first
  CHECK(listener->hear(1, kFrameLimit_ms));
  LONGS_EQUAL(7, listener->frames()[0].shot_id);
  LONGS_EQUAL(1, truths().size());
}

TEST(TabletOperator, WaitsForAnExposureThatIsStillUnderWay) {
  sit_down();
  const Exposure exposure = exposure_now(scene);
  exposure_store.set_exposing(exposure.line_on);
  listener->announce(1, exposure.line_on);
  CHECK(!listener->hear(1, kSilence_ms));
  exposure_store.add(exposure);
  exposure_store.set_exposing(std::nullopt);
  CHECK(listener->hear(1, kFrameLimit_ms));
}

TEST(TabletOperator, HasNoPhotographWhenTheShutterDidNotOpen) {
  sit_down();
  const Exposure exposure = exposure_now(scene, false);
  exposure_store.add(exposure);
  listener->announce(1, exposure.line_on);
  CHECK(!listener->hear(1, kSilence_ms));
  LONGS_EQUAL(1, truths().size());
  CHECK(truths()[0]["opened_ns"].is_null());
}

TEST(TabletOperator, TakesNoOtherShotsPhotograph) {
  sit_down();
  const Exposure earlier = exposure_now(scene);
  exposure_store.add(earlier);
  listener->announce(2, earlier.closed);
  CHECK(!listener->hear(1, kSilence_ms));
  LONGS_EQUAL(1, truths().size());
  LONGS_EQUAL(0, truths()[0]["shot"].get<int>());
  LONGS_EQUAL(2, truths()[0]["shot_id"].get<int>());
}

TEST(TabletOperator, ReportsAnEmptyPhotograph) {
  sit_down();
  const Exposure exposure = exposure_now(scene, true, false);
  exposure_store.add(exposure);
  listener->announce(1, exposure.line_on);
  CHECK(listener->hear(1, kFrameLimit_ms));
  LONGS_EQUAL(0, listener->frames()[0].image_count);
  LONGS_EQUAL(4, listener->frames()[0].surface_count);
}

TEST(TabletOperator, LeavesAPhotographLyingOrTakesItsTimeWhenTheSceneSaysSo) {
  scene.faults = {{.kind = FaultKind::no_photograph, .shot = 1}};
  sit_down();
  const Exposure exposure = exposure_now(scene);
  exposure_store.add(exposure);
  listener->announce(1, exposure.line_on);
  CHECK(!listener->hear(1, kSilence_ms));
  CHECK_EQUAL("[\"no_photograph\"]", truths()[0]["faults"].dump());
}

TEST(TabletOperator, SendsALateFrameLate) {
  scene.faults = {{.kind = FaultKind::frame_late, .shot = 1, .delay = milliseconds(600)}};
  sit_down();
  const Exposure exposure = exposure_now(scene);
  exposure_store.add(exposure);
  const MonoTime announced = RigClock{}.now();
  listener->announce(1, exposure.line_on);
  CHECK(listener->hear(1, kFrameLimit_ms));
  CHECK(RigClock{}.now() - announced >= milliseconds(650));
}

TEST(TabletOperator, WritesTheTruthOfAnnouncedShotsWhenItLeaves) {
  scene.faults = {{.kind = FaultKind::frame_late, .delay = milliseconds(60000)}};
  sit_down();
  const Exposure exposure = exposure_now(scene);
  exposure_store.set_exposing(exposure.line_on);
  listener->announce(3, exposure.line_on);
  listener->hear(1, kSilence_ms);
  exposure_store.add(exposure);
  desk->stop();
  LONGS_EQUAL(1, truths().size());
  LONGS_EQUAL(3, truths()[0]["shot_id"].get<int>());
}
