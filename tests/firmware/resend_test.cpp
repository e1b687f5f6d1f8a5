#include <cstdint>
#include <set>
#include <string>

#include "firmware/publisher/resend.hpp"
#include "tests/firmware/journal_messages.hpp"
#include "tests/support/journal_entries.hpp"
#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

using namespace strobe;
using namespace strobe::firmware;

TEST_GROUP(ResendQueue) {
  static constexpr std::int64_t kThis = 1, kEarlier = 2;
  ResendQueue queue;

  bool ask(std::int64_t host, std::int64_t boot, std::int64_t first, std::int64_t last) {
    return queue.add({host, {boot, {first, last}}, boot == kThis});
  }
  std::string next() {
    const auto range = queue.next();
    if (!range) return "none";
    return std::to_string(range->boot_id) + ": " + std::to_string(range->sequences.first) + " to " +
           std::to_string(range->sequences.last);
  }
};

TEST(ResendQueue, ServesHostsInTurnAndThisBootFirst) {
  for (std::int64_t k = 0; k < 3; ++k) CHECK_TRUE(ask(7, kEarlier, 10 * k + 1, 10 * k + 5));
  CHECK_TRUE(ask(8, kEarlier, 100, 200));
  CHECK_TRUE(ask(7, kThis, 1, 2));
  CHECK_EQUAL("1: 1 to 2", next());
  CHECK_EQUAL("2: 100 to 200", next());
  CHECK_EQUAL("2: 1 to 5", next());
  CHECK_EQUAL("2: 11 to 15", next());
  CHECK_FALSE(queue.empty());
  CHECK_EQUAL("2: 21 to 25", next());
  CHECK_TRUE(queue.empty());
  CHECK_EQUAL("none", next());
}

TEST(ResendQueue, EntersOnceWhatSeveralHostsAskForAgainAndAgain) {
  for (int times = 0; times < 3; ++times) {
    CHECK_TRUE(ask(7, kThis, 1, 100));
    CHECK_TRUE(ask(8, kThis, 1, 100));
    CHECK_TRUE(ask(8, kThis, 50, 60));
  }
  CHECK_EQUAL("1: 1 to 100", next());
  CHECK_TRUE(ask(8, kThis, 50, 60));  // is being answered
  CHECK_TRUE(queue.empty());
  CHECK_TRUE(ask(8, kThis, 50, 101));
  CHECK_EQUAL("1: 50 to 101", next());
  CHECK_EQUAL("none", next());
  CHECK_TRUE(ask(8, kThis, 50, 101));  // that answer is over
  CHECK_EQUAL("1: 50 to 101", next());
}

TEST(ResendQueue, BoundsWhatAHostAsksFor) {
  CHECK_TRUE(ask(7, kThis, -5, INT64_MAX));
  CHECK_EQUAL("1: 1 to 4096", next());
  CHECK_TRUE(ask(7, kThis, INT64_MAX - 1, INT64_MAX));
  CHECK_EQUAL("1: 9223372036854775806 to 9223372036854775807", next());
  CHECK_FALSE(ask(7, kThis, 6, 5));
  CHECK_FALSE(ask(7, kThis, INT64_MAX, INT64_MIN));
  CHECK_EQUAL("none", next());
}

TEST(ResendQueue, LetsNoHostTakeTheOthersPlaces) {
  std::int64_t entered = 0;
  for (std::int64_t host = 1; host <= 1000; ++host) {
    for (std::int64_t k = 1; k <= 100; ++k) {
      entered += ask(host, kThis, 1000 * host + k, 1000 * host + k) ? 1 : 0;
      entered += ask(host, kEarlier, 1000 * host + k, 1000 * host + k) ? 1 : 0;
    }
  }
  CHECK_EQUAL(static_cast<std::int64_t>(ResendQueue::kMaxHosts * 2 * ResendQueue::kMaxOfHost), entered);
  for (std::int64_t host = 1; host <= 16; ++host) {
    const std::string first = std::to_string(1000 * host + 1);
    CHECK_EQUAL("1: " + first + " to " + first, next());
  }
}

using namespace strobe;
using namespace strobe::firmware;
using namespace strobe::journal_test;

namespace {

constexpr std::int64_t kEvents = 20'000;
constexpr std::int64_t kShot_events = 40;  // every shot's, with five events between two shots
constexpr std::int64_t kEvery = 45;

}  // namespace

TEST_GROUP(RangeReader) {
  strobe::testing::TemporaryFolder folder;
  std::filesystem::path path;
  std::int64_t longest_step_bytes = 0, bytes = 0;

  /// Shots of forty events, 20,000 events in all: some 3 MB.
  void setup() override {
    auto journal = Journal::create(folder.path(), kBoot);
    path = journal->path();
    std::vector<Message> messages;
    for (std::int64_t k = 1; k <= kEvents; ++k) {
      const auto shot_id = static_cast<std::int32_t>((k - 1) / kEvery + 1);
      const std::int64_t within = (k - 1) % kEvery;
      messages.push_back(event(k, within < kShot_events ? shot_id : 0));
      if (within == kShot_events - 1) messages.push_back(shot(shot_id, {k - kShot_events + 1, k}));
    }
    CHECK(journal->append(messages, 0).has_value());
  }
  /// In words: "5 6 7 shot 2 (46 to 85)".
  std::string read(std::int64_t first, std::int64_t last) {
    RangeReader reader(path, {first, last});
    std::string words;
    wire::LogRecord record;
    for (;;) {
      const std::int64_t before = reader.bytes_read();
      const RangeReader::Step step = reader.step(record);
      longest_step_bytes = std::max(longest_step_bytes, reader.bytes_read() - before);
      bytes = reader.bytes_read();
      if (step == RangeReader::Step::done) return words;
      if (step == RangeReader::Step::searching) continue;
      const auto entry = entry_of(record);
      words += words.empty() ? "" : " ";
      words += entry->kind == Message::Kind::event ? std::to_string(entry->sequences.last)
                                                   : "shot " + std::to_string(entry->shot_id);
    }
  }
};

TEST(RangeReader, FindsEveryRangeWithTheShotsAmongIt) {
  CHECK_EQUAL("1 shot 1", read(1, 1));
  CHECK_EQUAL("39 40 shot 1 41 42", read(39, 42));
  CHECK_EQUAL("41 42", read(41, 42));
  CHECK_EQUAL("40 shot 1", read(40, 40));
  CHECK_EQUAL("44 45 46 47 shot 2", read(44, 47));
  CHECK_EQUAL("9999 10000 10001 10002 shot 223", read(9'999, 10'002));
  CHECK_EQUAL("19999 20000", read(19'999, 1'000'000));
  CHECK_EQUAL("", read(20'001, 30'000));
  CHECK_EQUAL("", read(8, 7));
}

/// 3 MB halved to 16 KiB are eight halvings, each of which reads two parts at most, then the range itself. A
/// reader that reads on from the journal's beginning takes half of it.
TEST(RangeReader, ReadsLittleOfAJournalForARange) {
  const auto size = static_cast<std::int64_t>(std::filesystem::file_size(path));
  CHECK(size > 2'500'000);
  constexpr auto kPart = static_cast<std::int64_t>(wire::LogReader::kPart_bytes);
  for (std::int64_t first = 1; first < kEvents; first += 997) {
    read(first, first + 9);
    CHECK(bytes <= 20 * kPart);
    CHECK(longest_step_bytes <= 2 * kPart);
  }
}

TEST(RangeReader, FindsWhatIsLeftOfADamagedJournal) {
  std::string text = strobe::testing::read_text(path);
  const auto entries = strobe::testing::journal_entries(path);
  // Most of the middle, in which every halving begins, is gone.
  const auto begin = static_cast<std::size_t>(entries[2'000].offset),
             end = static_cast<std::size_t>(entries[19'000].offset);
  text.replace(begin, end - begin, std::string(end - begin, '\0'));
  strobe::testing::write_text(path, text);
  const std::string last_before = std::to_string(entries[1'999].sequences.last);
  const std::string first_after = std::to_string(entries[19'000].sequences.last);
  const std::string shot_after = " shot " + std::to_string(entries[19'000].shot_id);
  CHECK(entries[19'000].shot_id != 0);
  CHECK_EQUAL(last_before + " " + first_after + shot_after,
              read(std::stoll(last_before), std::stoll(first_after)));
  CHECK_EQUAL("39 40 shot 1 41 42", read(39, 42));
  CHECK_EQUAL("19999 20000", read(19'999, 20'000));
  CHECK_EQUAL("", read(10'000, 10'010));
}

TEST(RangeReader, PassesOverWhatOnlyLooksLikeARecord) {
  // In every event's words an event of another number: where a halving begins, it comes first.
  auto journal = Journal::create(folder.path(), 8);
  auto inner = Journal::create(folder / "inner", 8);
  Message status = event(7);
  status.channel = "STROBE/bench/OTHER";
  CHECK(inner->append({status}, 0).has_value());
  const std::string fake = strobe::testing::read_text(inner->path());
  std::vector<Message> messages;
  for (std::int64_t k = 1; k <= 5'000; ++k) {
    messages.push_back(event(k));
    messages.push_back({Message::Kind::event, {k, k}, "STROBE/bench/STATUS", {fake.begin(), fake.end()}});
  }
  CHECK(journal->append(messages, 0).has_value());
  path = journal->path();
  for (std::int64_t k = 1; k <= 5'000; k += 61) CHECK_EQUAL(std::to_string(k), read(k, k));
}

TEST(RangeReader, HasNothingOfAJournalThatIsNotThere) {
  path = folder / "none";
  CHECK_EQUAL("", read(1, 100));
}
