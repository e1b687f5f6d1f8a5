// What resends cost the publisher, counted in bytes and in messages of each turn, never in time: STATUS and new
// events come between the parts of an answer however much hosts ask for.
#include <sys/resource.h>

#include <cstdio>
#include <map>
#include <string>
#include <strobe_msgs/event_t.hpp>
#include <strobe_msgs/status_t.hpp>

#include "common/messages/well_formed.hpp"
#include "firmware/publisher/publisher.hpp"
#include "tests/firmware/journal_messages.hpp"
#include "tests/support/journal_entries.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::firmware;

namespace {

constexpr std::int64_t kThisBoot = 99;
constexpr std::int64_t kEvents = 20'000;  // of an earlier boot: 3 MB

/// Bytes that this process has read from files.
std::int64_t bytes_read() {
  std::FILE* file = std::fopen("/proc/self/io", "r");
  CHECK(file != nullptr);
  long long bytes = -1;
  CHECK_EQUAL(1, std::fscanf(file, "rchar: %lld", &bytes));
  std::fclose(file);
  return bytes;
}

/// Moves on only when it is told to.
struct StandingClock final : Clock {
  MonoTime time = from_ns(1'000'000'000);
  MonoTime now() noexcept override { return time; }
  MonoTime spin_until(MonoTime instant) noexcept override { return time = std::max(time, instant); }
};

struct CountingBus final : MessageBus {
  std::map<std::string, int> count;
  std::map<std::int64_t, std::int64_t> newest;  ///< of each boot
  void publish(const std::string& channel, std::span<const std::uint8_t> bytes) override {
    ++count[channel];
    strobe_msgs::event_t event{};
    if (channel.ends_with("/EVENT") && messages::decode_checked(event, bytes.data(), bytes.size()))
      newest[event.boot_id] = std::max(newest[event.boot_id], event.sequence);
  }
};

struct NoWake final : Wake {
  bool wake() noexcept override { return true; }
};

}  // namespace

TEST_GROUP(ResendWork) {
  strobe::testing::TemporaryFolder folder;
  Rig rig;
  NoWake wake;
  StandingClock clock;
  CountingBus bus;
  LoopQueue queue{rig, wake};
  Mailbox mailbox;
  std::optional<Journal> journal;
  std::optional<Publisher> publisher;

  void earlier_boot(std::int64_t boot_id, std::int64_t events = kEvents) {
    auto made = Journal::create(folder.path(), boot_id);
    std::vector<Message> messages;
    for (std::int64_t k = 1; k <= events; ++k)
      messages.push_back(journal_test::event(k, k == events ? 1 : 0, boot_id));
    messages.push_back(journal_test::shot(1, {events, events}));
    CHECK(made->append(messages, boot_id).has_value());
  }
  void start() {
    PublisherSettings settings;
    settings.boot_id = kThisBoot;
    settings.session = folder.path();
    settings.found = repair_journals(folder.path());
    settings.say = [](const std::string&) {};
    journal.emplace(std::move(*Journal::create(folder.path(), kThisBoot)));
    publisher.emplace(rig, std::move(settings), queue, mailbox, *journal, bus, clock);
    publisher->turn();
  }
  void happen(EventKind kind = EventKind::key) {
    Event event;
    event.kind = kind;
    queue.event(event);
  }
};

TEST(ResendWork, OfATurnIsBoundedHoweverMuchIsAskedFor) {
  for (std::int64_t boot = 1; boot <= 8; ++boot) earlier_boot(boot);
  start();
  for (std::int64_t host = 1; host <= 20; ++host) {
    for (std::int64_t boot = 1; boot <= 8; ++boot) {
      for (std::int64_t k = 0; k < 4; ++k)
        mailbox.ask({host, {boot, {1 + 5000 * k + host, INT64_MAX}}, false});
    }
  }
  std::int64_t most_bytes = 0;
  int most_messages = 0, turns = 0;
  for (; mailbox.resends_wait() && turns < 100'000; ++turns) {
    const std::int64_t before = bytes_read();
    const int sent = bus.count["STROBE/bench/EVENT"];
    publisher->turn();
    most_bytes = std::max(most_bytes, bytes_read() - before);
    most_messages = std::max(most_messages, bus.count["STROBE/bench/EVENT"] - sent);
  }
  CHECK(turns > 100 && turns < 100'000);
  // One part or record beyond, what a stream reads ahead (8 KiB), and /proc/self/io itself.
  CHECK(most_bytes <= Publisher::kTurn_bytes + 2 * static_cast<std::int64_t>(wire::LogReader::kPart_bytes));
  CHECK(most_messages <= 128);
}

TEST(ResendWork, LeavesStatusAndNewEventsTheFirstPlaceInEveryTurn) {
  earlier_boot(1);
  start();
  mailbox.ask({5, {1, {1, INT64_MAX}}, false});
  publisher->turn();
  CHECK(bus.newest[1] > 0 && bus.newest[1] < 4096);
  for (std::int64_t k = 1; bus.newest[1] < 4096; ++k) {
    const int statuses = bus.count["STROBE/bench/STATUS"];
    clock.time = clock.time + milliseconds(500);
    happen();
    publisher->turn();
    CHECK_EQUAL(statuses + 1, bus.count["STROBE/bench/STATUS"]);
    CHECK_EQUAL(k, bus.newest[kThisBoot]);
    CHECK(k < 100);
  }
}

TEST(ResendWork, AnswersInPartsUntilAHostHasAll) {
  earlier_boot(1);
  start();
  while (bus.newest[1] < kEvents) {
    const std::int64_t before = bus.newest[1];
    mailbox.ask({5, {1, {before + 1, INT64_MAX}}, false});
    for (int turn = 0; turn < 200; ++turn) publisher->turn();
    CHECK(bus.newest[1] > before);
  }
  CHECK_EQUAL(kEvents, static_cast<std::int64_t>(bus.count["STROBE/bench/EVENT"]));
}

TEST(ResendWork, IsLeftOutWhileThereIsNoDescriptorAndTheRestGoesOn) {
  earlier_boot(1);
  start();
  rlimit before{};
  getrlimit(RLIMIT_NOFILE, &before);
  const rlimit none{0, before.rlim_max};
  setrlimit(RLIMIT_NOFILE, &none);
  mailbox.ask({5, {1, {1, 100}}, false});
  happen();
  const int statuses = bus.count["STROBE/bench/STATUS"];
  clock.time = clock.time + milliseconds(500);
  for (int turn = 0; turn < 10; ++turn) publisher->turn();
  setrlimit(RLIMIT_NOFILE, &before);
  CHECK_EQUAL(0, bus.newest[1]);
  CHECK_EQUAL(1, bus.newest[kThisBoot]);
  CHECK_EQUAL(statuses + 1, bus.count["STROBE/bench/STATUS"]);
  CHECK_TRUE(queue.journal_ok());
  mailbox.ask({5, {1, {1, 100}}, false});  // as a host does, once more
  for (int turn = 0; turn < 10; ++turn) publisher->turn();
  CHECK_EQUAL(100, bus.newest[1]);
}

TEST(ResendWork, OfAStartDoesNotGrowWithTheJournals) {
  const auto cost = [this] {
    const std::int64_t before = bytes_read();
    const FolderFindings found = repair_journals(folder.path());
    CHECK_EQUAL(3u, found.earlier.size());
    CHECK_EQUAL(3, found.earlier.front().boot_id);
    return bytes_read() - before;
  };
  for (std::int64_t boot = 1; boot <= 3; ++boot) earlier_boot(boot, kEvents);
  const std::int64_t small = cost();
  for (std::int64_t boot = 1; boot <= 3; ++boot) {
    std::filesystem::remove(journal_path(folder.path(), boot));
    earlier_boot(boot, 10 * kEvents);
  }
  CHECK(cost() <= small + 1024);  // what this counts with is read, too
}

TEST(ResendWork, LooksThroughTheLastJournalForDamageWithoutDelayingTheStart) {
  earlier_boot(1);
  const auto path = journal_path(folder.path(), 1);
  std::string text = strobe::testing::read_text(path);
  const auto damaged = static_cast<std::size_t>(strobe::testing::journal_entries(path)[7].offset);
  text.replace(damaged, 40, std::string(40, '\0'));
  strobe::testing::write_text(path, text);
  start();
  happen(EventKind::started);
  for (int turn = 0; turn < 100; ++turn) {
    const std::int64_t before = bytes_read();
    publisher->turn();
    CHECK(bytes_read() - before <=
          Publisher::kTurn_bytes + 2 * static_cast<std::int64_t>(wire::LogReader::kPart_bytes));
  }
  CHECK_EQUAL(2, bus.newest[kThisBoot]);
  const std::string told = strobe::testing::read_text(journal->path());
  CHECK(told.find("bytes in the middle of its journal are damaged") != std::string::npos);
}
