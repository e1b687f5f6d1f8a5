// The simulated camera on its sockets, in the machine's time: what a receiver of our own gets of the rig's exposures.
#include "sim/gev/gev_camera.hpp"

#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <bit>
#include <cstring>
#include <map>
#include <thread>

#include "sim/loading/load_scene.hpp"
#include "sim/photograph/render.hpp"
#include "sim/shoot/shoot.hpp"
#include "tests/sim/gev/commands.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using namespace strobe::sim;
using namespace strobe::sim::gev;
using namespace std::chrono_literals;
using strobe::testing::Datagram;
using strobe::testing::gvcp;
using strobe::testing::word_of;
using strobe::testing::write_register;

constexpr std::uint32_t kCameraAddress = 0x7f00010b;  // 127.0.1.11
constexpr std::uint64_t kSeed = 4;
constexpr auto kLongestReply = 10'000ms;  // for what must come
constexpr auto kSilence = 500ms;          // for what must not

Scene small_scene(const std::string& more = "") {
  auto scene = parse_scene(
      "[machine]\nspeed_mps = 17\nangle_deg = -23\nspin_radps = 0\n"
      "[bounce]\ne = 0.8\nmu = 0.6\ndwell_ms = 5\n"
      "[camera]\npx_per_m = 200\norigin_x_px = 75\norigin_y_px = 15\n" +
          more,
      "small.toml");
  if (!scene) FAIL(scene.error().message.c_str());
  return *scene;
}

/// A frame as it came.
struct Received {
  std::map<std::uint32_t, Datagram> packets;  ///< by their ids
  bool whole() const {
    return !packets.empty() && packets.rbegin()->second[4] == 2 && packets.size() == packets.rbegin()->first + 1;
  }
  std::uint64_t timestamp() const {
    return std::uint64_t{word_of(packets.at(0), 12)} << 32 | word_of(packets.at(0), 16);
  }
  Datagram pixels() const {
    Datagram all;
    for (const auto& [id, packet] : packets)
      if (packet[4] == 3) all.insert(all.end(), packet.begin() + 8, packet.end());
    return all;
  }
};

class Socket {
 public:
  Socket() : fd_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    const sockaddr_in own = place(INADDR_LOOPBACK, 0);
    CHECK_EQUAL(0, bind(fd_, reinterpret_cast<const sockaddr*>(&own), sizeof own));
  }
  ~Socket() { close(fd_); }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  std::uint16_t port() const {
    sockaddr_in own{};
    socklen_t size = sizeof own;
    getsockname(fd_, reinterpret_cast<sockaddr*>(&own), &size);
    return ntohs(own.sin_port);
  }
  void send(const Datagram& datagram) const {
    const sockaddr_in camera = place(kCameraAddress, 3956);
    sendto(fd_, datagram.data(), datagram.size(), 0, reinterpret_cast<const sockaddr*>(&camera), sizeof camera);
  }
  /// Empty: none came.
  Datagram receive(std::chrono::milliseconds limit) const {
    pollfd polled{fd_, POLLIN, 0};
    if (::poll(&polled, 1, static_cast<int>(limit.count())) != 1) return {};
    Datagram bytes(65536);
    const ssize_t count = recv(fd_, bytes.data(), bytes.size(), 0);
    bytes.resize(count < 0 ? 0 : static_cast<std::size_t>(count));
    return bytes;
  }

 private:
  static sockaddr_in place(std::uint32_t address, std::uint16_t port) {
    sockaddr_in socket{};
    socket.sin_family = AF_INET;
    socket.sin_addr.s_addr = htonl(address);
    socket.sin_port = htons(port);
    return socket;
  }
  const int fd_;
};

}  // namespace

TEST_GROUP(GevCamera) {
  ExposureStore exposure_store;
  std::unique_ptr<gev::GevCamera> camera;
  Socket control, stream;

  void start(const Scene& scene) {
    auto created = gev::GevCamera::create("127.0.1.11", scene, kSeed, exposure_store);
    if (!created) FAIL(created.error().message.c_str());
    camera = std::move(*created);
    camera->start(true);
  }
  void set(std::uint32_t address, std::uint32_t value) {
    control.send(write_register(address, value));
    const Datagram answer = control.receive(kLongestReply);
    CHECK_TRUE(answer.size() >= 8 && word_of(answer, 0) >> 16 == 0);
  }
  /// As a host sets it for shots: Mono12, all automatic modes off, exposure by the line.
  void arm(std::uint32_t exposure_mode = 1) {
    set(0x0a00, 2);
    set(0x0d18, INADDR_LOOPBACK);
    set(0x0d00, stream.port());
    set(camera::kPixelFormat, static_cast<std::uint32_t>(PixelFormat::mono12));
    set(camera::kExposureAuto, 0);
    set(camera::kGainAuto, 0);
    set(camera::kBlackLevel, std::bit_cast<std::uint32_t>(41.0F));
    set(camera::kTriggerMode, 1);
    set(camera::kExposureMode, exposure_mode);
    set(camera::kAcquisitionStart, 1);
  }
  static Exposure simulated(const Scene& scene, int shot) {
    auto made = shoot(scene, kSeed, shot, Model::full(), {.exposure = milliseconds(20)});
    if (!made) FAIL(made.error().message.c_str());
    return made->exposure;
  }
  /// That of the shot: its shutter has just closed.
  Exposure expose(const Scene& scene, int shot) {
    Exposure exposure = simulated(scene, shot);
    std::this_thread::sleep_for(exposure.closed - exposure.opened);  // so that it began after the camera was armed
    const Duration shift = RigClock{}.now() - exposure.closed;
    exposure.opened += shift;
    exposure.closed += shift;
    exposure.line_on += shift;
    for (Pulse& pulse : exposure.pulses) {
      pulse.edge += shift;
      for (MonoTime& flash : pulse.flashes) flash += shift;
    }
    if (exposure.ball) exposure.ball->touchdown += shift;
    exposure_store.add(exposure);
    return exposure;
  }
  /// By block; until there is silence.
  std::map<std::uint32_t, Received> frames() {
    std::map<std::uint32_t, Received> found;
    auto limit = std::chrono::milliseconds(kLongestReply);
    for (Datagram packet = stream.receive(limit); packet.size() >= 8; packet = stream.receive(limit)) {
      found[word_of(packet, 0)].packets[word_of(packet, 4) & 0xffffff] = packet;
      limit = kSilence;
    }
    return found;
  }
  static Datagram rendered(Scene scene, const Exposure& exposure) {
    scene.photograph.bits = 12;
    scene.photograph.gamma = 1.0;
    scene.photograph.black_level = 41.0 / 4095.0;
    const auto photograph = render(scene, kSeed, exposure);
    const auto* const begin = photograph->pixels.ptr(0);
    return {begin, begin + photograph->pixels.total() * photograph->pixels.elemSize()};
  }
};

TEST(GevCamera, SendsTheShotsPhotographWithTheInstantOfItsExposure) {
  const Scene scene = small_scene("[camera_link]\nclock_offset_s = 100\n");
  start(scene);
  arm();
  const Exposure first = expose(scene, 1);
  const auto received = frames();
  const Exposure second = expose(scene, 2);
  const auto more = frames();
  LONGS_EQUAL(1, received.size());
  LONGS_EQUAL(1, more.size());
  CHECK_TRUE(received.at(1).whole() && more.at(2).whole());
  CHECK_TRUE(received.at(1).pixels() == rendered(scene, first));
  CHECK_TRUE(more.at(2).pixels() == rendered(scene, second));
  CHECK(received.at(1).timestamp() > 100'000'000'000U);
  // Its clock is not off in rate: to the nanosecond.
  UNSIGNED_LONGS_EQUAL((second.opened - first.opened).count(), more.at(2).timestamp() - received.at(1).timestamp());
}

TEST(GevCamera, SendsAgainWhatIsAskedFor) {
  const Scene scene = small_scene();
  start(scene);
  arm();
  expose(scene, 1);
  const auto received = frames();
  stream.send(gvcp(0x0040, {1, 1, 2}));  // block 1, packets 1 and 2
  const auto again = frames();
  CHECK_TRUE(again.at(1).packets.size() == 2);
  CHECK_TRUE(again.at(1).packets.at(2) == received.at(1).packets.at(2));
  stream.send(gvcp(0x0040, {77, 1, 2}));
  const Datagram unavailable = stream.receive(kLongestReply);
  LONGS_EQUAL(0x800c, word_of(unavailable, 0) >> 16);
}

TEST(GevCamera, SeesOnlyTheFlashesOfATimedExposure) {
  const Scene scene = small_scene();
  start(scene);
  arm(0);
  const Exposure whole = simulated(scene, 1);
  const MonoTime middle = whole.pulses[whole.pulses.size() / 2].edge;
  const auto half_ms = std::chrono::duration_cast<milliseconds>(middle - whole.opened);
  set(camera::kExposureTime, std::bit_cast<std::uint32_t>(1000.0F * static_cast<float>(half_ms.count())));
  Exposure exposure = expose(scene, 1);
  const auto received = frames();
  CHECK_FALSE(received.at(1).pixels() == rendered(scene, exposure));
  exposure.closed = exposure.opened + half_ms;
  CHECK_TRUE(received.at(1).pixels() == rendered(scene, exposure));
}

TEST(GevCamera, SendsNothingOfAShotWithoutAPhotograph) {
  const Scene scene = small_scene(
      "[[fault]]\nkind = \"no_photograph\"\nshot = 1\n[[fault]]\nkind = \"frame_dropped\"\nshot = 2\n"
      "[[fault]]\nkind = \"frame_twice\"\nshot = 3\n");
  start(scene);
  arm();
  for (const int shot : {1, 2, 3}) expose(scene, shot);
  const auto received = frames();
  // The first was not exposed; the second was counted, the third came as two.
  LONGS_EQUAL(2, received.size());
  CHECK_TRUE(received.at(2).whole() && received.at(3).whole());
  CHECK_TRUE(received.at(2).pixels() == received.at(3).pixels());
  UNSIGNED_LONGS_EQUAL(received.at(2).timestamp(), received.at(3).timestamp());
}

TEST(GevCamera, IsGoneForAWhileAndThenSwitchedOnAnew) {
  const Scene scene = small_scene("[[fault]]\nkind = \"camera_vanishes\"\nshot = 1\ndelay_s = 0.3\n");
  start(scene);
  arm();
  expose(scene, 1);
  Datagram answer;
  for (int tries = 0; answer.empty() && tries < 200; ++tries) {
    std::this_thread::sleep_for(20ms);
    control.send(gvcp(0x0080, {camera::kTriggerMode, 0x0a00}));
    answer = control.receive(50ms);
    if (answer.size() >= 16 && word_of(answer, 8) == 1) answer.clear();  // not gone yet
  }
  LONGS_EQUAL(16, answer.size());
  LONGS_EQUAL(0, word_of(answer, 8));
  LONGS_EQUAL(0, word_of(answer, 12));
  CHECK_TRUE(stream.receive(kSilence).empty());
}

TEST(GevCamera, AddressesOfOtherMachinesAreRefused) {
  CHECK_FALSE(gev::GevCamera::create("10.0.0.1", small_scene(), kSeed, exposure_store).has_value());
  CHECK_FALSE(gev::GevCamera::create("127.0.1", small_scene(), kSeed, exposure_store).has_value());
  start(small_scene());
  const auto second = gev::GevCamera::create("127.0.1.11", small_scene(), kSeed, exposure_store);
  CHECK_FALSE(second.has_value());
  STRCMP_CONTAINS("port 3956 of 127.0.1.11 cannot be used", second.error().message.c_str());
}
