#include "tests/host/others/stored_photographs.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <strobe_msgs/shot_t.hpp>
#include <vector>

#include "host/session/session_folder.hpp"
#include "tests/support/program_run.hpp"
#include "tests/support/sealed_sender.hpp"

#include <CppUTest/TestHarness.h>

namespace strobe::others {
namespace {

namespace fs = std::filesystem;
using strobe_msgs::shot_t;

constexpr std::int64_t kStart_ns = 1'000'000'000'000;

shot_t shot_of(const nlohmann::json& truth, std::int64_t boot_id, int shot_id) {
  shot_t shot{};
  shot.schema_version = shot_t::SCHEMA_VERSION;
  shot.boot_id = boot_id;
  shot.shot_id = shot_id;
  shot.host_id = 5;
  shot.first_sequence = 1;  // ... to 0: none
  shot.plan.period_ns = 3'000'000;
  shot.plan.shutter_open_ns = 150'000'000;
  shot.start_ns = kStart_ns;
  shot.shutter_on_ns = shot.shutter_open_ns = kStart_ns;
  shot.shutter_off_ns = shot.shutter_close_ns = kStart_ns + 150'000'000;
  shot.trigger_ns = kStart_ns;
  shot.gate_ns = shot_t::NO_TIME;
  shot.lamp_delay_a_us = shot.lamp_delay_b_us = 12.0;
  shot.sensor_a_fitted = shot.sensor_b_fitted = true;
  shot.late_tolerance_us = 50.0;
  for (const auto& time : truth.at("flash_times_s")) {
    strobe_msgs::flash_t flash{};
    const std::int64_t seen_ns = kStart_ns + std::llround(time.get<double>() * 1e9);
    flash.flash_index = static_cast<std::int32_t>(shot.flashes.size());
    flash.lamps = 3;
    flash.commanded_ns = flash.issue_start_ns = flash.issue_end_ns = seen_ns - 12'000;
    flash.observed_a_ns = flash.observed_b_ns = seen_ns;
    shot.flashes.push_back(flash);
  }
  shot.flash_count = static_cast<std::int32_t>(shot.flashes.size());
  return shot;
}

std::vector<nlohmann::json> render(const fs::path& folder, const std::string& scene, int shots) {
  const std::string file = folder.string() + ".toml";
  testing::write_text(file, "inherits = \"" + scene +
                                "\"\n[camera]\npx_per_m = 1500\norigin_x_px = 560\norigin_y_px = 110\n");
  return testing::jsons_of(
      testing::run_program({STROBE_BUILD_DIR "/bin/strobe-sim", "photograph", "--scene", file, "--shots",
                            std::to_string(shots), "--seed", "11", "--out", folder, "--json"}));
}

}  // namespace

StoredPhotographs::StoredPhotographs() {
  testing::write_text(key_file(), key_.text() + "\n");
  fs::permissions(key_file(), fs::perms::owner_read | fs::perms::owner_write);
}

fs::path StoredPhotographs::add_session(const std::string& name, const std::string& scene, int shots) {
  const fs::path session = path() / name, pictures = path() / (name + ".rendered");
  const auto truths = render(pictures, scene, shots);
  ++boot_;
  auto folder = host::SessionFolder::open(
      session, "20260131T093000Z", "rig = \"bench\"\n[analysis]\npx_per_m = 1500\npx_per_m_sd = 0.15\n", "");
  CHECK_TRUE(folder.has_value());
  fs::create_directories(session / "photographs");
  testing::SealedSender sender(key_, boot_);
  for (int id = 1; id <= shots; ++id) {
    const shot_t shot = shot_of(truths.at(static_cast<std::size_t>(id - 1)), boot_, id);
    (*folder)->log("STROBE/bench/SHOT", sender.packet("STROBE/bench/SHOT", shot),
                   WallTime{microseconds{1'769'851'800'000'000 + id}});
    fs::rename(pictures / fmt::format("shot_{:04}.tif", id),
               session / fmt::format("photographs/shot-{:04}-camera.tif", id));
  }
  (*folder)->close();
  CHECK_FALSE((*folder)->failed());
  return session;
}

}  // namespace strobe::others
