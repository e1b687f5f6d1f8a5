// The publisher on a private LCM: what is journalled is published, in order, and can be had again.
#include "firmware/publisher/publisher.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <string>
#include <strobe_msgs/status_t.hpp>
#include <thread>

#include "firmware/linux/event_fd.hpp"
#include "firmware/linux/system_clock.hpp"
#include "firmware/publisher/lcm_bus.hpp"
#include "tests/support/journal_entries.hpp"
#include "tests/support/temporary_folder.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::firmware;

namespace {
std::atomic<int> syncs{0};
}

/// Stands in for the C library's, which the journal calls.
extern "C" int fdatasync(int fd) {
  ++syncs;
  return fsync(fd);
}

namespace {

constexpr std::int64_t kBoot = 0xb007;

/// Everything that came over LCM.
struct Listener {
  std::vector<strobe_msgs::event_t> events;
  std::vector<strobe_msgs::shot_t> shots;
  std::vector<strobe_msgs::status_t> statuses;

  void on_event(const lcm::ReceiveBuffer*, const std::string&, const strobe_msgs::event_t* m) {
    events.push_back(*m);
  }
  void on_shot(const lcm::ReceiveBuffer*, const std::string&, const strobe_msgs::shot_t* m) {
    shots.push_back(*m);
  }
  void on_status(const lcm::ReceiveBuffer*, const std::string&, const strobe_msgs::status_t* m) {
    statuses.push_back(*m);
  }
};

}  // namespace

TEST_GROUP(Publisher) {
  strobe::testing::TemporaryFolder folder;
  Rig rig;
  EventFd wake_up;
  lcm::LCM lcm{"memq://"};
  SystemClock clock;
  LcmBus bus{lcm};
  LoopQueue queue{rig, wake_up};
  Mailbox mailbox;
  Listener listener;
  PublisherSettings settings;
  FolderFindings& found = settings.found;
  std::optional<Journal> journal;
  std::optional<Publisher> publisher;
  std::jthread thread;

  void setup() override {
    lcm.subscribe("STROBE/bench/EVENT", &Listener::on_event, &listener)->setQueueCapacity(10'000);
    lcm.subscribe("STROBE/bench/SHOT", &Listener::on_shot, &listener)->setQueueCapacity(10'000);
    lcm.subscribe("STROBE/bench/STATUS", &Listener::on_status, &listener)->setQueueCapacity(10'000);
    journal.emplace(std::move(*Journal::create(folder.path(), kBoot)));
  }
  void teardown() override { stop(); }
  void make() {
    settings.boot_id = kBoot;
    settings.session = folder.path();
    publisher.emplace(rig, settings, queue, mailbox, *journal, bus, clock);
  }
  void start() {
    make();
    thread = std::jthread([this](const std::stop_token& token) { publisher->run(token, wake_up.fd()); });
  }
  void wake() { CHECK_TRUE(wake_up.wake()); }
  void stop() {
    if (!thread.joinable()) return;
    thread.request_stop();
    wake();
    thread.join();
  }
  template <typename Condition>
  bool until(Condition && condition) {
    const MonoTime end = clock.now() + milliseconds(10'000);
    while (!condition() && clock.now() < end) lcm.handleTimeout(10);
    return condition();
  }
  void tell(EventKind kind) {
    Event event;
    event.kind = kind;
    queue.event(event);
    queue.flush();
  }
  void play_shot(int shot_id, int flashes) {
    Event event;
    event.shot_id = shot_id;
    event.kind = EventKind::shot_started;
    queue.event(event);
    event.kind = EventKind::flash;
    for (event.flash_index = 0; event.flash_index < flashes; ++event.flash_index) {
      event.commanded = from_ns(1'000'000);
      event.issue_start = from_ns(1'000'100);  // lateness ends here, not with the call
      event.issue_end = from_ns(1'000'400);
      queue.event(event);
    }
    event.kind = EventKind::shot_ended;
    queue.event(event);
    ShotRecord* record = queue.free_record();
    record->shot_id = shot_id;
    record->host_id = 5;
    record->command_id = 1;
    record->flashes.resize(static_cast<std::size_t>(flashes));
    CHECK_TRUE(queue.shot_done(record));
    queue.flush();
  }
};

TEST(Publisher, JournalsAndPublishesAShotWithItsEvents) {
  rig.record = {{"operator", "rig"}};
  mailbox.keep({5, 1, {{"operator", "host"}}});
  start();
  play_shot(3, 100);
  CHECK_TRUE(until([&] { return listener.shots.size() == 1; }));
  CHECK_EQUAL(102u, listener.events.size());
  for (std::size_t k = 0; k < listener.events.size(); ++k)
    CHECK_EQUAL(static_cast<std::int64_t>(k) + 1, listener.events[k].sequence);
  const auto& shot = listener.shots[0];
  CHECK_EQUAL(1, shot.first_sequence);
  CHECK_EQUAL(102, shot.last_sequence);
  CHECK_EQUAL(std::string("host"), shot.notes[0].value);
  CHECK_EQUAL(103u, strobe::testing::journal_entries(journal->path()).size());
}

TEST(Publisher, NamesTheCulpritOfWhatWasLateAndOfNothingElse) {
  std::vector<std::pair<MonoTime, MonoTime>> asked;
  settings.culprit = [&](MonoTime from, MonoTime to) {
    asked.emplace_back(from, to);
    return "kworker/1:2 (pid 71) ran for 912 us";
  };
  start();
  Event event;
  event.shot_id = 3;
  event.kind = EventKind::shot_started;
  queue.event(event);
  event.kind = EventKind::flash;
  event.commanded = from_ns(1'000'000);
  for (const Duration lateness : {rig.tolerance.late, rig.tolerance.late + microseconds(1)}) {
    event.issue_start = event.commanded + lateness;
    event.issue_end = event.issue_start + milliseconds(1);
    queue.event(event);
  }
  event.kind = EventKind::shot_aborted;
  event.device_time = from_ns(9'000'000);
  event.detail = "flash 2 would have been 8000 us late";
  queue.event(event);
  event.kind = EventKind::shot_aborted;  // not for lateness
  event.commanded = kNoTime;
  event.detail = "the key is off";
  queue.event(event);
  ShotRecord* record = queue.free_record();
  record->shot_id = 3;
  record->abort_reason = "flash 2 would have been 8000 us late";
  CHECK_TRUE(queue.shot_done(record));
  queue.flush();
  CHECK_TRUE(until([&] { return listener.shots.size() == 1; }));
  stop();
  CHECK_EQUAL(2u, asked.size());
  CHECK_TRUE(asked[0] == std::pair(from_ns(1'000'000), from_ns(1'000'000) + rig.tolerance.late + microseconds(1)));
  CHECK_TRUE(asked[1] == std::pair(from_ns(1'000'000), from_ns(9'000'000)));
  STRCMP_EQUAL("", listener.events[1].detail.c_str());
  STRCMP_EQUAL("101 us late: kworker/1:2 (pid 71) ran for 912 us", listener.events[2].detail.c_str());
  const char* aborted = "flash 2 would have been 8000 us late: kworker/1:2 (pid 71) ran for 912 us";
  STRCMP_EQUAL(aborted, listener.events[3].detail.c_str());
  STRCMP_EQUAL("the key is off", listener.events[4].detail.c_str());
  STRCMP_EQUAL(aborted, listener.shots[0].abort_reason.c_str());
}

TEST(Publisher, SyncsTheJournalAfterEachShotAndAtTheEnd) {
  start();
  CHECK_TRUE(until([&] { return !listener.statuses.empty(); }));
  const int before = syncs;
  play_shot(1, 10);
  CHECK_TRUE(until([&] { return listener.shots.size() == 1; }));
  CHECK_TRUE(until([&] { return syncs == before + 1; }));
  play_shot(2, 10);
  CHECK_TRUE(until([&] { return listener.shots.size() == 2; }));
  CHECK_TRUE(until([&] { return syncs == before + 2; }));
  stop();
  CHECK_EQUAL(before + 3, syncs.load());
}

TEST(Publisher, SyncsWhatAStopOrItsEndSaysInTheTurnThatWritesIt) {
  make();
  for (const EventKind kind :
       {EventKind::key, EventKind::estop, EventKind::disarmed, EventKind::fault, EventKind::cleared}) {
    const std::size_t written = strobe::testing::journal_entries(journal->path()).size();
    const int before = syncs;
    tell(kind);
    publisher->turn();
    CHECK_EQUAL(before + 1, syncs.load());
    CHECK_EQUAL(written + 1, strobe::testing::journal_entries(journal->path()).size());
    publisher->turn();
    CHECK_EQUAL(before + 1, syncs.load());
  }
}

TEST(Publisher, SyncsOnceInATurnHoweverMuchItWrites) {
  make();
  const int before = syncs;
  for (int i = 0; i < 2'000; ++i) tell(EventKind::estop);  // a loose contact; several batches
  publisher->turn();
  CHECK_EQUAL(before + 1, syncs.load());
  CHECK_EQUAL(2'000u, strobe::testing::journal_entries(journal->path()).size());
}

TEST(Publisher, IsNotHeldUpByTheDiskForWhatIsNotOfSafety) {
  make();
  const int before = syncs;
  for (const EventKind kind : {EventKind::started, EventKind::armed, EventKind::refused, EventKind::gate,
                               EventKind::flash, EventKind::sensor})
    tell(kind);
  publisher->turn();
  CHECK_EQUAL(before, syncs.load());
}

TEST(Publisher, SyncsAStopThatTheDiskDidNotTakeAtFirstOnceItDoes) {
  make();
  const std::filesystem::path away = folder / "away";
  std::filesystem::rename(journal->path(), away);
  const int before = syncs;
  tell(EventKind::estop);
  publisher->turn();
  CHECK_EQUAL(before, syncs.load());
  std::filesystem::rename(away, journal->path());
  publisher->turn();
  CHECK_EQUAL(before + 1, syncs.load());
}

TEST(Publisher, BeatsAtLeastTwiceASecondAndTellsLateness) {
  start();
  CHECK_TRUE(until([&] { return listener.statuses.size() >= 5; }));
  CHECK_TRUE(std::isnan(listener.statuses[0].histograms.at(0).p50_us));
  std::int64_t shortest_ns = INT64_MAX;  // a machine that stands still makes any single gap longer
  for (std::size_t k = 2; k < 5; ++k)
    shortest_ns = std::min(shortest_ns, listener.statuses[k].mono_ns - listener.statuses[k - 1].mono_ns);
  CHECK(shortest_ns >= 500'000'000 && shortest_ns <= 510'000'000);
  play_shot(1, 10);
  CHECK_TRUE(until([&] { return listener.statuses.back().histograms.at(0).count == 10; }));
  DOUBLES_EQUAL(0.1, listener.statuses.back().histograms.at(0).p50_us, 1e-9);
  DOUBLES_EQUAL(0.3, listener.statuses.back().histograms.at(1).p50_us, 1e-9);
  CHECK_EQUAL(12, listener.statuses.back().last_sequence);
  CHECK_EQUAL(kBoot, listener.statuses.back().boot_id);
}

TEST(Publisher, TellsOnceThatItsStartIsPublishedAndBeatsForTheWatchdog) {
  int told = 0;
  std::atomic<std::int64_t> heartbeat_ns{0};
  settings.on_first_status = [&told] { ++told; };
  settings.heartbeat_ns = &heartbeat_ns;
  make();
  publisher->turn();  // a status, but nothing has happened yet
  CHECK_EQUAL(0, told);
  CHECK(heartbeat_ns > 0);
  for (int shot = 1; shot <= 2; ++shot) {
    play_shot(shot, 1);
    queue.status(LoopStatus{});
    publisher->turn();
    CHECK_EQUAL(1, told);
  }
}

TEST(Publisher, DrillsAtEachFlashFromTheShotThatWasNamedOn) {
  int drilled = 0;
  settings.drill_at_shot = 2;
  settings.drill = [&drilled] { ++drilled; };
  make();
  play_shot(1, 3);
  publisher->turn();
  CHECK_EQUAL(0, drilled);
  play_shot(2, 3);
  publisher->turn();
  CHECK_EQUAL(3, drilled);
}

TEST(Publisher, SaysAtOnceWhatIsMissing) {
  start();
  LoopStatus status;
  status.estop_active = false;
  queue.status(status);
  queue.flush();
  CHECK_TRUE(until([&] {
    return !listener.statuses.empty() &&
           listener.statuses.back().message == "the key is off, or its wire is broken";
  }));
  status.key_active = true;
  status.fault = "broken";
  queue.status(status);
  queue.flush();
  CHECK_TRUE(until([&] { return listener.statuses.back().message == "fault: broken"; }));
}

TEST(Publisher, SendsAgainWhatIsAskedForAndTheShotsAmongIt) {
  start();
  play_shot(1, 1000);
  CHECK_TRUE(until([&] { return listener.shots.size() == 1; }));
  listener = Listener{};
  mailbox.ask({5, {kBoot, {500, 505}}});
  wake();
  CHECK_TRUE(until([&] { return listener.events.size() == 6 && listener.shots.size() == 1; }));
  CHECK_EQUAL(500, listener.events.front().sequence);
  CHECK_EQUAL(505, listener.events.back().sequence);
  listener = Listener{};
  mailbox.ask({5, {kBoot, {1, INT64_MAX}}});
  wake();
  CHECK_TRUE(until([&] { return listener.events.size() == 1002 && listener.shots.size() == 1; }));
}

TEST(Publisher, GoesOnWithAResendLongBeforeItsNextHeartbeat) {
  make();
  play_shot(1, 1000);
  publisher->turn();
  mailbox.ask({5, {kBoot, {1, INT64_MAX}}});
  publisher->turn();
  CHECK(publisher->next_turn() < clock.now() + milliseconds(100));
  for (int turn = 0; turn < 8; ++turn) publisher->turn();  // 128 messages each
  CHECK(publisher->next_turn() > clock.now() + milliseconds(100));
}

TEST(Publisher, SendsAgainWhatAnEarlierBootJournalled) {
  {
    auto earlier = Journal::create(folder.path(), 77);
    Event event;
    const auto message = to_message(event, 77, 1);
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
    message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    CHECK(earlier->append({{Message::Kind::event, {1, 1}, "STROBE/bench/EVENT", bytes}}, 0).has_value());
  }
  start();
  mailbox.ask({5, {77, {1, INT64_MAX}}, false});
  mailbox.ask({5, {78, {1, INT64_MAX}}, false});  // no such boot: nothing to send, no harm
  wake();
  CHECK_TRUE(until([&] { return listener.events.size() == 1; }));
  CHECK_EQUAL(77, listener.events[0].boot_id);
}

TEST(Publisher, KeepsNumbersForShotsAheadAndGivesTheRestBack) {
  ShotNumbers numbers(folder.path(), 0);
  settings.numbers = &numbers;
  make();
  publisher->turn();
  CHECK_EQUAL(ShotNumbers::kAtOnce, queue.shot_id_limit());
  LoopStatus status;
  for (status.last_shot_id = 1; status.last_shot_id <= 100; ++status.last_shot_id) {
    queue.status(status);
    publisher->turn();
    CHECK(queue.shot_id_limit() >= status.last_shot_id + ShotNumbers::kAtOnce / 2);
    CHECK(ShotNumbers::read(folder.path()) == queue.shot_id_limit());
  }
  publisher->finish();
  CHECK(ShotNumbers::read(folder.path()) == 100);
}

TEST(Publisher, GivesNoNumberBackWhileEventsAreNotJournalled) {
  ShotNumbers numbers(folder.path(), 0);
  settings.numbers = &numbers;
  make();
  publisher->turn();
  std::filesystem::remove(journal->path());
  play_shot(1, 3);
  publisher->finish();
  CHECK(ShotNumbers::read(folder.path()) == ShotNumbers::kAtOnce);
}

TEST(Publisher, TellsWhatEarlierStartsLeftAfterItsOwnStart) {
  found.repaired = {"boot 77: 12 bytes were cut off", "boot 77: shot 3 has no end"};
  found.earlier = std::vector<EarlierBoot>(20, EarlierBoot{77, 5});
  start();
  Event event;
  event.kind = EventKind::started;
  queue.event(event);
  queue.flush();
  CHECK_TRUE(until([&] { return listener.events.size() == 3; }));
  CHECK_EQUAL(strobe_msgs::event_t::STARTED, listener.events[0].kind);
  CHECK_EQUAL(strobe_msgs::event_t::REPAIRED, listener.events[1].kind);
  CHECK_EQUAL(2, listener.events[1].sequence);
  CHECK_EQUAL(std::string("boot 77: shot 3 has no end"), listener.events[2].detail);
  CHECK_TRUE(until([&] { return !listener.statuses.empty(); }));
  CHECK_EQUAL(16, listener.statuses[0].earlier_count);
  CHECK_EQUAL(5, listener.statuses[0].earlier[0].last_sequence);
}

TEST(Publisher, HoldsEventsBackWhileTheJournalCannotBeWritten) {
  start();
  std::filesystem::remove(journal->path());
  play_shot(1, 3);
  CHECK_TRUE(until([&] { return !listener.statuses.empty() && !listener.statuses.back().journal_ok; }));
  STRCMP_CONTAINS("the journal was removed", listener.statuses.back().message.c_str());
  CHECK_FALSE(queue.journal_ok());
  CHECK_EQUAL(0u, listener.events.size());
}

TEST(Publisher, SaysThatThereIsNoRoomForAShotBeforeItIsArmedFor) {
  start();
  CHECK_TRUE(until([&] { return !listener.statuses.empty() && listener.statuses.back().journal_ok; }));
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit tight{static_cast<rlim_t>(Journal::kShotRoom / 2), before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &tight);  // as a disk that is nearly full
  play_shot(1, 3);
  const bool withdrawn = until([&] { return !listener.statuses.back().journal_ok; });
  setrlimit(RLIMIT_FSIZE, &before);
  CHECK_TRUE(withdrawn);
  STRCMP_CONTAINS("no room for another shot", listener.statuses.back().message.c_str());
  CHECK_FALSE(queue.journal_ok());
  CHECK_EQUAL(1u, listener.shots.size());  // what could be written is published
  CHECK_TRUE(until([&] { return listener.statuses.back().journal_ok != 0; }));
}

TEST(Publisher, WritesWhatIsLeftWhenItIsStopped) {
  start();
  play_shot(1, 2000);
  stop();
  CHECK_EQUAL(2003u, strobe::testing::journal_entries(journal->path()).size());
}
