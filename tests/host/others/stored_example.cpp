#include "tests/host/others/stored_example.hpp"

#include <strobe_msgs/event_t.hpp>
#include <strobe_msgs/shot_t.hpp>

#include "host/session/session_folder.hpp"
#include "tests/support/sealed_sender.hpp"

#include <CppUTest/TestHarness.h>

namespace strobe::others {
namespace {

using strobe_msgs::event_t;
using strobe_msgs::shot_t;

host::Shot result_of(int shot_id, double e) {
  host::Shot result;
  result.boot_id = kBoot;
  result.shot_id = shot_id;
  result.readout.value[reduction::Quantity::e] = e;
  result.readout.method = "best";
  result.readout.record = {{"remarks", "wet, \"fast\""}};
  return result;
}

event_t event_of(std::int64_t sequence) {
  event_t event{};
  event.schema_version = event_t::SCHEMA_VERSION;
  event.boot_id = kBoot;
  event.sequence = sequence;
  event.kind = event_t::SENSOR;
  event.device_time_ns = 1'000'000'000 + sequence;
  event.commanded_ns = event_t::NO_TIME;
  event.issue_start_ns = event_t::NO_TIME;
  event.issue_end_ns = event_t::NO_TIME;
  event.flash_index = -1;
  event.detail = "a, \"b\"\n=1+1";
  return event;
}

shot_t shot_of(int shot_id) {
  shot_t shot{};
  shot.schema_version = shot_t::SCHEMA_VERSION;
  shot.boot_id = kBoot;
  shot.shot_id = shot_id;
  shot.plan.period_ns = 3'000'000;
  shot.flash_count = 2;
  shot.flashes.resize(2);
  for (int i = 0; i < 2; ++i) {
    strobe_msgs::flash_t& flash = shot.flashes[static_cast<std::size_t>(i)];
    flash.flash_index = i;
    flash.lamps = 3;
    flash.commanded_ns = 1'000'000'000 + 3'000'000 * i;
    flash.observed_a_ns = flash.commanded_ns + 4'000;
    flash.observed_b_ns = i == 0 ? shot_t::NO_TIME : flash.commanded_ns + 5'000;
  }
  return shot;
}

}  // namespace

StoredExample::StoredExample() : key_file(keys / "lab.key") {
  testing::write_text(key_file, key.text() + "\n");
  std::filesystem::permissions(key_file,
                               std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  auto session = host::SessionFolder::open(folder.path(), "20260131T093000Z", "rig = \"bench\"\n", "");
  CHECK_TRUE(session.has_value());
  testing::SealedSender sender(key, kBoot);
  const WallTime wall{microseconds{1'769'851'800'000'000}};
  for (int i = 1; i <= 3; ++i)
    (*session)->log("STROBE/bench/EVENT", sender.packet("STROBE/bench/EVENT", event_of(i)), wall);
  (*session)->log("STROBE/bench/SHOT", sender.packet("STROBE/bench/SHOT", shot_of(1)), wall);
  (*session)->log("OTHER/LAB", messages::encode(event_of(1)), wall);
  (*session)->add(shot_of(1));
  auto rejected = result_of(3, 0.5);
  rejected.rejected = "too few images";
  for (const auto& result : {result_of(1, 0.80), result_of(2, 0.84), rejected})
    (*session)->add(result, "2026-01-31T09:30:00.000Z");
  (*session)->close();
  CHECK_FALSE((*session)->failed());
}

}  // namespace strobe::others
