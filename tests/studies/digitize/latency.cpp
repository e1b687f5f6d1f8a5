#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <thread>

#include "common/messages/channels.hpp"
#include "common/messages/well_formed.hpp"
#include "host/clock/machine_clock.hpp"
#include "host/commands/terminal.hpp"
#include "host/loop/host_loop.hpp"
#include "host/photographs/photograph_pipeline.hpp"
#include "sim/loading/load_scene.hpp"
#include "tests/studies/digitize/photographs.hpp"
#include "tests/studies/digitize/shot_message.hpp"
#include "tests/studies/digitize/studies.hpp"
#include "tests/support/temporary_folder.hpp"

namespace strobe::studies::digitize {

namespace {

namespace fs = std::filesystem;
using host::steady_now;

/// Until what was written is at rest.
constexpr auto kPause = std::chrono::milliseconds(30);

struct Shot {
  sim::Scene scene;
  KnownPhotograph known;
  std::vector<unsigned char> bytes;
};

struct Timing {
  double readout_ms = 0.0;  ///< rename to readout
  bool whole = false;       ///< the readout has both velocities
};

/// A running `strobe live`, without the network: messages are handed to it here.
class Live final : host::Transport, host::HostListener {
 public:
  explicit Live(const host::RigFile& rig)
      : loop_({rig.rig, host::assembly_settings(rig), host::random_host_id()}, *this, clock_) {
    loop_.add_listener(*this);
  }

  Result<void> open(const host::RigFile& rig, const std::string& effort, const fs::path& folder) {
    auto photographs = host::open_pipeline(rig, {folder.string(), effort}, "", loop_.settings().host_id,
                                           loop_.session().clock(), clock_.read());
    if (!photographs) return tl::unexpected(photographs.error());
    loop_.set_photographs(std::move(*photographs));
    return {};
  }

  void announce(const std::string& rig, const strobe_msgs::shot_t& shot) {
    strobe_msgs::status_t status{};
    status.schema_version = strobe_msgs::status_t::SCHEMA_VERSION;
    status.boot_id = shot.boot_id;
    status.mono_ns = to_ns(steady_now());
    loop_.receive(messages::channel_name(rig, messages::Channel::status), messages::encode(status));
    loop_.receive(messages::channel_name(rig, messages::Channel::shot), messages::encode(shot));
    loop_.step();
  }

  std::optional<host::Shot> wait_for_readout(HostTime until) {
    while (!result_ && steady_now() < until) loop_.run_once();
    return std::exchange(result_, std::nullopt);
  }

 private:
  bool receive(std::chrono::milliseconds max_wait, std::span<const int> descriptors,
               const Receiver&) override {
    std::vector<pollfd> polled;
    for (const int descriptor : descriptors) polled.push_back({descriptor, POLLIN, 0});
    ::poll(polled.data(), polled.size(), static_cast<int>(max_wait.count()));
    return true;
  }
  void publish(const std::string&, Bytes) override {}
  void on_shot_result(const host::Shot& result) override { result_ = result; }

  host::MachineClock clock_;
  host::HostLoop loop_;
  std::optional<host::Shot> result_;
};

Result<std::vector<Shot>> render_all(const Options& options) {
  const auto names = scene_names(options.scenes);
  if (!names) return tl::unexpected(names.error());
  std::vector<Shot> shots;
  for (int i = 0; i < options.shots.value_or(21); ++i) {
    const auto count = static_cast<int>(names->size());
    auto scene = sim::load_scene((*names)[static_cast<std::size_t>(i % count)]);
    if (!scene) return tl::unexpected(scene.error());
    const Take take{*scene, options.seed, i / count + 1, options.keep};
    auto known = known_photograph(take);
    if (!known) return tl::unexpected(known.error());
    auto bytes = photograph_bytes(take, known->shot);
    if (!bytes) return tl::unexpected(bytes.error());
    shots.push_back({std::move(*scene), std::move(*known), std::move(*bytes)});
  }
  return shots;
}

Result<Timing> time_one(const Shot& shot, int shot_id, const std::string& effort, const fs::path& folder) {
  const host::RigFile rig =
      rig_of(shot.scene, {shot.known.scene_truth.px_per_m, 2.0, shot.scene.ball.diameter_m, 0.0001});
  Live live(rig);
  if (auto opened = live.open(rig, effort, folder); !opened) return tl::unexpected(opened.error());
  live.announce(rig.rig, shot_message(shot.known, shot.scene, shot_id, to_ns(steady_now())));
  const fs::path whole = folder / fmt::format("exposure-{:04}.tif", shot_id);
  const fs::path part = whole.string() + ".part";
  std::ofstream file(part, std::ios::binary);
  file.write(reinterpret_cast<const char*>(shot.bytes.data()),
             static_cast<std::streamsize>(shot.bytes.size()));
  file.close();
  std::this_thread::sleep_for(kPause);
  std::error_code error;
  const HostTime start = steady_now();
  fs::rename(part, whole, error);
  if (!file || error) return fail(whole.string() + ": cannot be written");
  const auto shot_result = live.wait_for_readout(start + std::chrono::seconds{10});
  const double ms = 1e3 * to_seconds(steady_now() - start);
  fs::remove(whole, error);
  if (!shot_result) return fail(shot.scene.name + ": no readout within 10 s");
  const auto& value = shot_result->readout.value;
  return Timing{ms, value[reduction::Quantity::vx_td_mps] && value[reduction::Quantity::vx_lo_mps]};
}

double percentile(const std::vector<double>& sorted, double share) {
  return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1) + 0.5)];
}

Result<void> study_effort(const Options& options, const std::string& effort, const std::vector<Shot>& shots) {
  const testing::TemporaryFolder folder;
  std::vector<double> times_ms;
  int whole = 0, shot_id = 0;
  for (const Shot& shot : shots) {
    double least_ms = 1e300;
    for (int round = 0; round < options.rounds; ++round) {
      const auto timing = time_one(shot, ++shot_id, effort, folder.path());
      if (!timing) return tl::unexpected(timing.error());
      least_ms = std::min(least_ms, timing->readout_ms);
      if (round == 0 && timing->whole) ++whole;
    }
    times_ms.push_back(least_ms);
  }
  std::ranges::sort(times_ms);
  fmt::print("{:<9} {:>11} {:>6.1f} {:>8.1f} {:>7.1f} {:>7.1f} {:>7.1f} {:>14}\n", effort, shots.size(),
             times_ms.front(), percentile(times_ms, 0.5), percentile(times_ms, 0.9),
             percentile(times_ms, 0.99), times_ms.back(), whole);
  std::fflush(stdout);
  return {};
}

}  // namespace

Result<void> study_latency(const Options& options) {
  const auto shots = render_all(options);
  if (!shots) return tl::unexpected(shots.error());
  const auto& first = shots->front().known.photograph;
  fmt::print("ms from rename to readout, {} x {} px uncompressed, {} round{} each\n", first.width(),
             first.height(), options.rounds, options.rounds == 1 ? "" : "s");
  fmt::print("{:<9} {:>11} {:>6} {:>8} {:>7} {:>7} {:>7} {:>14}\n", "effort", "photographs", "least",
             "median", "p90", "p99", "most", "both legs read");
  for (const char* effort : {"fast", "standard"})
    if (auto done = study_effort(options, effort, *shots); !done) return done;
  return {};
}

}  // namespace strobe::studies::digitize
