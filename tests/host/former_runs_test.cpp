// What is read of a session's earlier runs, and what a later run makes of it.
#include "host/session/former_runs.hpp"

#include <string>
#include <strobe_msgs/command_t.hpp>
#include <strobe_msgs/readout_t.hpp>

#include "common/messages/channels.hpp"
#include "common/messages/well_formed.hpp"
#include "host/loop/resumption.hpp"
#include "host/messages/command_factory.hpp"
#include "host/session/shot_table.hpp"
#include "host/session/session_folder.hpp"
#include "tests/host/synthetic_shot.hpp"
#include "tests/support/host_bench.hpp"
#include "tests/support/sealed_sender.hpp"
#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

namespace {

using namespace strobe;
using host::FormerRuns;
using host::Shot;
using messages::Channel;
using strobe_msgs::event_t;
using strobe_msgs::status_t;
using testing::write_text;

constexpr const char* kUtc = "20260131T093000Z";
constexpr std::int64_t kBoot = 77, kBefore = 0x51, kHost = 0x1234, kOther = 0x99;

std::string channel(Channel kind) { return messages::channel_name("bench", kind); }

event_t event_of(std::int8_t kind, std::int64_t sequence, std::int32_t shot_id = 0,
                 const std::string& detail = "") {
  event_t event{};
  event.schema_version = event_t::SCHEMA_VERSION;
  event.boot_id = kBoot;
  event.sequence = sequence;
  event.kind = kind;
  event.shot_id = shot_id;
  event.detail = detail;
  return event;
}

struct Results final : host::HostListener {
  std::vector<Shot> results;
  void on_shot_result(const Shot& result) override { results.push_back(result); }
};

}  // namespace

TEST_GROUP(FormerRuns) {
  testing::TemporaryFolder folder;
  const authentication::Key key = authentication::Key::random();
  testing::SealedSender lab{key};
  host_test::SyntheticShot made = host_test::make_shot({});
  std::unique_ptr<host::SessionFolder> log;
  testing::RememberingBus bus;
  testing::ManualClock clock;
  Results results;

  void setup() override {
    log = std::move(*host::SessionFolder::open(folder.path(), kUtc, "", ""));
    made.shot.boot_id = made.frame.boot_id = kBoot;
    made.shot.shot_id = made.frame.shot_id = 6;
    made.shot.host_id = kBefore;
    made.shot.first_sequence = 1;
    made.shot.last_sequence = 2;
    clock.now = Duration{made.shot.shutter_close_ns};  // of the firmware's clock, which the host's is here
  }
  template <typename Message>
  void keep(Channel kind, const Message& message) {
    log->log(channel(kind), lab.packet(channel(kind), message),
             WallTime{std::chrono::seconds{1'800'000'000}});
  }
  void keep_fire(std::int64_t host_id, std::int64_t token = 9) {
    host::CommandFactory factory(host_id);
    const auto sealed = host::CommandSealer(key, "bench").seal(factory.fire(kBoot, token, {}, {}));
    log->log(channel(Channel::command), *sealed, {});
  }
  void keep_shot() {
    keep_fire(kBefore);
    keep(Channel::event, event_of(event_t::SHOT_STARTED, 1, 6));
    keep(Channel::event, event_of(event_t::SHOT_ENDED, 2, 6));
    keep(Channel::shot, made.shot);
  }
  FormerRuns read() { return host::read_former_runs(folder.path(), "bench", key).value(); }

  /// Some turns of a later run.
  void run_later(std::int64_t running_boot = kBoot) {
    host::HostLoopSettings settings{"bench", {}, kHost, true, key};
    settings.assembly.machine_lag_s = host_test::kMachineLag_s;
    settings.assembly.analysis.photograph_timeout_s = 5.0;
    host::HostLoop loop(settings, bus, clock);
    loop.add_listener(results);
    host::Resumption resumption(loop, read());
    status_t status{};
    status.schema_version = status_t::SCHEMA_VERSION;
    status.boot_id = running_boot;
    status.last_sequence = running_boot == kBoot ? 2 : 0;
    status.key_active = status.journal_ok = true;
    testing::SealedSender firmware{key, running_boot};
    bool finished = false;
    for (int turn = 0; turn < 2000 && !finished; ++turn) {
      clock.now += milliseconds{20};
      if (turn % 25 == 0) {
        status.mono_ns = status.boot_time_ns = status.wall_ns = clock.now.count();
        bus.arriving.emplace_back(channel(Channel::status),
                                  firmware.packet(channel(Channel::status), status));
      }
      loop.run_once();
      finished = resumption.finished();
    }
    CHECK_TRUE(finished);
    loop.step();
  }
};

TEST(FormerRuns, AreNoneInANewFolder) {
  const FormerRuns former = read();
  CHECK_TRUE(former.empty());
  CHECK_FALSE(former.may_lack_results());
  LONGS_EQUAL(0, former.counted());
}

TEST(FormerRuns, RowsOfTheTableTellWhichShotsCount) {
  Shot counts, rejected;
  counts.boot_id = rejected.boot_id = 0x2a;
  counts.shot_id = 1;
  rejected.shot_id = 2;
  rejected.rejected = "it said \"no\", twice";
  std::string table = host::results_header() + "\n" + host::results_line(counts) + "\n" +
                      host::results_line(rejected) + "\n";
  counts.shot_id = 3;
  table += host::results_line(counts);  // torn: no end
  write_text(folder / "results.csv", table);
  const auto rows = host::read_result_rows(folder.path()).value();
  LONGS_EQUAL(2, rows.size());
  CHECK_TRUE(rows.at({0x2a, 1}));
  CHECK_FALSE(rows.at({0x2a, 2}));
  LONGS_EQUAL(1, read().counted());
}

TEST(FormerRuns, ATableOfAnySizeIsCounted) {
  constexpr int kShots = 20'000;
  std::string table = host::results_header() + "\n";
  for (int shot = 1; shot <= kShots; ++shot)
    table += "2026-01-31T09:30:00.000Z,2a," + std::to_string(shot) + ",," + std::string(1000, '0') +
             ",\"a note\nof two lines\"\n";
  write_text(folder / "results.csv", table);
  CHECK_TRUE(table.size() > std::size_t{16} << 20);
  LONGS_EQUAL(kShots, host::read_result_rows(folder.path()).value().size());
  LONGS_EQUAL(kShots, read().counted());
}

TEST(FormerRuns, WhatCannotBeReadIsAnErrorAndNotNothing) {
  const auto error = [this] {
    const auto former = host::read_former_runs(folder.path(), "bench", key);
    return former ? std::string() : former.error().message;
  };
  CHECK_EQUAL("", error());
  for (const char* name : {"results.csv", "runs.jsonl"}) {
    write_text(folder / name, "");
    std::filesystem::resize_file(folder / name, std::uintmax_t{1} << 40);
    CHECK_EQUAL((folder / name).string() + ": a line is longer than 1 MB", error());
    std::filesystem::remove(folder / name);
    std::filesystem::create_directory(folder / name);
    CHECK_EQUAL((folder / name).string() + ": Is a directory", error());
    std::filesystem::remove(folder / name);
  }
  write_text(folder / "results.csv",
             "\"" + std::string(700'000, 'x') + "\n" + std::string(700'000, 'x') + "\n\n");
  CHECK_EQUAL((folder / "results.csv").string() + ": a quoted field has no end", error());
  std::filesystem::remove(folder / "results.csv");
  std::filesystem::create_symlink("nowhere", folder / "host-20260131T093001Z.lcmlog");
  CHECK_EQUAL((folder / "host-20260131T093001Z.lcmlog").string() + ": No such file or directory", error());
}

TEST(FormerRuns, MessagesOfStrangersAreNotReadFromALog) {
  keep(Channel::event, event_of(event_t::SHOT_STARTED, 1, 6));
  log->log(channel(Channel::event), messages::encode(event_of(event_t::FLASH, 2)), {});
  log->log(channel(Channel::event), lab.packet("STROBE/other/EVENT", event_of(event_t::FLASH, 3)), {});
  log->log(channel(Channel::event), std::vector<std::uint8_t>{1, 2, 3}, {});
  // its last field, an empty text with its end, says that it is -1 bytes long
  auto hostile = messages::encode(event_of(event_t::FLASH, 4));
  std::fill(hostile.end() - 5, hostile.end() - 1, std::uint8_t{0xff});
  log->log(channel(Channel::event), lab.packet(channel(Channel::event), authentication::Bytes(hostile)), {});
  LONGS_EQUAL(1, read().events.size());
}

TEST(FormerRuns, AHostThatSentAFireIsOneOfThem) {
  keep_fire(kBefore);
  keep(Channel::shot, made.shot);
  made.shot.shot_id = 7;
  made.shot.host_id = kOther;
  keep(Channel::shot, made.shot);
  const FormerRuns former = read();
  CHECK_TRUE(former.own(former.shots.at({kBoot, 6})));
  CHECK_FALSE(former.own(former.shots.at({kBoot, 7})));
  LONGS_EQUAL(1, former.unfinished().size());
  CHECK_TRUE(former.may_lack_results());
}

TEST(FormerRuns, AFireWithoutASummaryMayHaveBeenAShot) {
  keep_fire(kBefore);
  CHECK_TRUE(read().unfinished().empty());
  CHECK_TRUE(read().may_lack_results());
}

TEST(FormerRuns, AShotWhosePhotographWasMeasuredGetsItsResult) {
  keep_shot();
  keep(Channel::frame, made.frame);
  run_later();
  LONGS_EQUAL(1, results.results.size());
  CHECK_FALSE(results.results[0].rejected.has_value());
  LONGS_EQUAL(kBefore, results.results[0].host_id);
  LONGS_EQUAL(1, bus.sent_on(channel(Channel::readout)).size());
}

TEST(FormerRuns, AReadoutThatWasPublishedIsNotPublishedAgain) {
  keep_shot();
  keep(Channel::frame, made.frame);
  strobe_msgs::readout_t readout{};
  readout.boot_id = kBoot;
  readout.shot_id = 6;
  keep(Channel::readout, readout);
  run_later();
  LONGS_EQUAL(1, results.results.size());
  LONGS_EQUAL(0, bus.sent_on(channel(Channel::readout)).size());
}

TEST(FormerRuns, AShotWithoutAPhotographIsNamedWithItsReason) {
  keep_shot();
  run_later();
  LONGS_EQUAL(1, results.results.size());
  CHECK_TRUE(results.results[0].readout.flags.has(reduction::Flag::no_photograph));
}

TEST(FormerRuns, AShotInTheTableGetsNoSecondResult) {
  keep_shot();
  keep(Channel::frame, made.frame);
  Shot stored;
  stored.boot_id = kBoot;
  stored.shot_id = 6;
  log->add(stored, "2026-01-31T09:30:00.000Z");
  run_later();
  LONGS_EQUAL(0, results.results.size());
}

TEST(FormerRuns, OthersShotsAreNotTakenIn) {
  keep_shot();
  made.shot.host_id = kOther;
  made.shot.shot_id = made.frame.shot_id = 7;
  keep(Channel::shot, made.shot);
  keep(Channel::frame, made.frame);
  run_later();
  for (const Shot& result : results.results) LONGS_EQUAL(kBefore, result.host_id);
}

TEST(FormerRuns, AShotOfWhichNoJournalHasTheSummaryIsTold) {
  keep_fire(kBefore);
  keep(Channel::event, event_of(event_t::ARMED, 1, 0, "51 anna@desk"));
  keep(Channel::event, event_of(event_t::SHOT_STARTED, 2, 6));
  run_later(kBoot + 1);
  LONGS_EQUAL(1, results.results.size());
  LONGS_EQUAL(6, results.results[0].shot_id);
  CHECK_TRUE(results.results[0].rejected.has_value());
  CHECK_TRUE(results.results[0].readout.flags.has(reduction::Flag::events_missing));
}
