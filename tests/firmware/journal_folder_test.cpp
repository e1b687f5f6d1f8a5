#include <chrono>
#include <fcntl.h>
#include <string>
#include <sys/stat.h>
#include <unistd.h>

#include "firmware/publisher/journal.hpp"
#include "firmware/publisher/journal_folder.hpp"
#include "tests/firmware/journal_messages.hpp"
#include "tests/support/journal_entries.hpp"
#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::firmware;

namespace {

using namespace strobe::journal_test;

std::string joined(const std::vector<std::string>& lines) {
  std::string all;
  for (const std::string& line : lines) all += line + "\n";
  return all;
}

}  // namespace

TEST_GROUP(JournalFolder) {
  strobe::testing::TemporaryFolder folder;

  std::filesystem::path journal(std::int64_t boot_id, const std::vector<Message>& messages,
                                std::int64_t wall_us = 0) {
    auto made = Journal::create(folder.path(), boot_id);
    CHECK(made->append(messages, wall_us).has_value());
    return made->path();
  }
  FolderFindings repair() { return repair_journals(folder.path()); }
};

TEST(JournalFolder, GivesTheLargestShotOfAllBoots) {
  CHECK_EQUAL(0, repair().last_shot_id);
  CHECK_EQUAL(0, repair_journals(folder / "none").last_shot_id);
  journal(1, {event(1, 8), shot(8, {1, 1}), event(2, 8)}, 1);  // the last comes late, and opens no shot
  journal(2, {event(1, 3), shot(3, {1, 1})});
  strobe::testing::write_text(folder / "host-20260101T000000Z.lcmlog", "not the firmware's");
  strobe::testing::write_text(folder / "journal-garbage.lcmlog", std::string(1000, '\xed'));
  const FolderFindings findings = repair();
  CHECK_EQUAL(8, findings.last_shot_id);
  CHECK_EQUAL("", joined(findings.repaired));
}

TEST(JournalFolder, ListsEarlierBootsTheNewestFirstAlsoWhereTheClockWasSetBack) {
  using namespace std::chrono_literals;
  const auto older = journal(9, {event(1), event(2), event(3)}, 2'000);
  journal(7, {event(1), event(2)}, 1'000);
  std::filesystem::last_write_time(older, std::filesystem::file_time_type::clock::now() + 24h);
  journal(5, {}, 3'000);  // ended before its first event was written
  const FolderFindings findings = repair();
  CHECK_EQUAL(2u, findings.earlier.size());
  CHECK_EQUAL(EarlierBoot({7, 2}), findings.earlier[0]);
  CHECK_EQUAL(EarlierBoot({9, 3}), findings.earlier[1]);
}

TEST(JournalFolder, CutsATornEndAtAnyByteAndSaysSo) {
  const auto path = journal(kBoot, {event(1), event(2), event(3)});
  const std::string whole = strobe::testing::read_text(path);
  const auto last = static_cast<std::size_t>(strobe::testing::journal_entries(path)[2].offset);
  for (std::size_t size = last + 1; size < whole.size(); ++size) {
    strobe::testing::write_text(path, whole.substr(0, size));
    const FolderFindings findings = repair();
    CHECK_EQUAL(last, std::filesystem::file_size(path));
    const std::string what = std::to_string(size - last) + " bytes (a torn ";
    CHECK_EQUAL(1u, findings.repaired.size());
    STRCMP_CONTAINS(("boot 1122334455667788: " + what).c_str(), findings.repaired[0].c_str());
    STRCMP_CONTAINS(") after event 2 were cut off", findings.repaired[0].c_str());
    CHECK(findings.repaired[0].size() <= 160);
  }
  CHECK_EQUAL("", joined(repair().repaired));  // once is enough
}

TEST(JournalFolder, CutsZerosThatTheFileSystemLeft) {
  const auto path = journal(kBoot, {event(1), shot(1, {1, 1})});
  const auto size = std::filesystem::file_size(path);
  std::filesystem::resize_file(path, size + 5000);
  CHECK_EQUAL("boot 1122334455667788: 5000 bytes (zeros) after event 1 were cut off\n",
              joined(repair().repaired));
  CHECK_EQUAL(size, std::filesystem::file_size(path));
}

TEST(JournalFolder, KeepsWhatFollowsADamagedStretch) {
  const auto path = journal(kBoot, {event(1), event(2), event(3)});
  std::string text = strobe::testing::read_text(path);
  text.replace(static_cast<std::size_t>(strobe::testing::journal_entries(path)[1].offset), 40,
               std::string(40, '\0'));
  strobe::testing::write_text(path, text);
  STRCMP_CONTAINS("bytes in the middle of its journal are damaged", joined(repair().repaired).c_str());
  CHECK_EQUAL(text.size(), std::filesystem::file_size(path));
  CHECK_EQUAL(EarlierBoot({kBoot, 3}), repair().earlier.front());
}

TEST(JournalFolder, RepairsAndListsALargeJournalByItsEnd) {
  std::vector<Message> messages;
  for (std::int64_t k = 1; k <= 5'000; ++k) messages.push_back(event(k, k > 4'990 ? 3 : 0));
  const auto path = journal(kBoot, messages);
  const auto size = std::filesystem::file_size(path);
  std::filesystem::resize_file(path, size - 1);
  const FolderFindings findings = repair();
  CHECK_EQUAL(3, findings.last_shot_id);
  CHECK_EQUAL(EarlierBoot({kBoot, 4'999}), findings.earlier.at(0));
  CHECK_EQUAL(2u, findings.repaired.size());
  STRCMP_CONTAINS("after event 4999 were cut off", findings.repaired[0].c_str());
  STRCMP_CONTAINS("shot 3 has no end; what came after event 4999 is lost", findings.repaired[1].c_str());
  CHECK(findings.unchecked_boot == kBoot);
  CHECK_EQUAL(4'999u, strobe::testing::journal_entries(path).size());
}

TEST(JournalFolder, FindsAnEndBeforeAnyStretchOfZeros) {
  const auto path = journal(kBoot, {event(1), event(2)});
  const auto size = std::filesystem::file_size(path);
  for (const std::uintmax_t zeros : {std::uintmax_t{70'000}, std::uintmax_t{2'000'000}}) {
    std::filesystem::resize_file(path, size + zeros);
    CHECK_EQUAL(
        "boot 1122334455667788: " + std::to_string(zeros) + " bytes (zeros) after event 2 were cut off\n",
        joined(repair().repaired));
    CHECK_EQUAL(size, std::filesystem::file_size(path));
  }
  std::filesystem::resize_file(path, size + (std::uintmax_t{17} << 20));
  CHECK_EQUAL("journal-1122334455667788.lcmlog has no record in its last 16 MiB, and is left as it is\n",
              joined(repair().repaired));
}

TEST(JournalFolder, RepairsTheLatestJournalsOnlyAndKeepsTheirOrder) {
  using namespace std::chrono_literals;
  const auto now = std::filesystem::file_time_type::clock::now();
  for (std::int64_t boot = 1; boot <= 20; ++boot) {
    const auto path = journal(boot, {event(1), event(2)}, boot);
    std::filesystem::resize_file(path, std::filesystem::file_size(path) - 1);
    std::filesystem::last_write_time(path, now - 1h * (20 - boot));
  }
  for (int start = 0; start < 2; ++start) {
    const FolderFindings findings = repair();
    CHECK_EQUAL(FolderFindings::kLatest, findings.earlier.size());
    CHECK_EQUAL(EarlierBoot({20, 1}), findings.earlier.front());
    CHECK_EQUAL(EarlierBoot({5, 1}), findings.earlier.back());
    CHECK_EQUAL(start == 0 ? FolderFindings::kLatest : 0u, findings.repaired.size());
  }
}

TEST(JournalFolder, LeavesAloneWhatIsNoJournal) {
  const auto path = folder / "journal-00000000000000aa.lcmlog";
  strobe::testing::write_text(path, "the notes of last week");
  CHECK_EQUAL("journal-00000000000000aa.lcmlog is no journal, and is left as it is\n",
              joined(repair().repaired));
  CHECK_EQUAL("the notes of last week", strobe::testing::read_text(path));
}

TEST(JournalFolder, LeavesAloneAJournalThatIsBeingWritten) {
  auto other = Journal::create(folder.path(), kBoot);
  CHECK(other->append({event(1, 4), event(2, 4)}, 0).has_value());
  const auto size = std::filesystem::file_size(other->path());
  std::filesystem::resize_file(other->path(), size - 5);  // as in the middle of a write
  const FolderFindings findings = repair();
  CHECK_EQUAL(4, findings.last_shot_id);
  CHECK_TRUE(findings.repaired.empty() && findings.earlier.empty());
  CHECK_EQUAL(size - 5, std::filesystem::file_size(other->path()));
}

TEST(JournalFolder, NamesTheShotThatHasNoEnd) {
  journal(kBoot, {event(1, 6), event(2, 6), shot(6, {1, 2}), event(3), event(4, 7), event(5, 7)}, 1'000);
  const std::string lost = "boot 1122334455667788: shot 7 has no end; what came after event 5 is lost\n";
  CHECK_EQUAL(lost, joined(repair().repaired));
  journal(2, {event(1)}, 2'000);  // it has reported it
  CHECK_EQUAL("", joined(repair().repaired));
}

TEST(JournalFolder, GivesBackTheRoomThatADeadDaemonHadSetAside) {
  const auto path = journal(kBoot, {event(1)});
  const int fd = open(path.c_str(), O_WRONLY | O_CLOEXEC);
  const auto size = static_cast<off_t>(std::filesystem::file_size(path));
  const bool set_aside = fallocate(fd, FALLOC_FL_KEEP_SIZE, size, 2 * Journal::kShotRoom) == 0;
  close(fd);
  if (!set_aside) return;  // this file system cannot
  CHECK_EQUAL("", joined(repair().repaired));
  struct stat file {};
  CHECK_EQUAL(0, stat(path.c_str(), &file));
  CHECK(file.st_blocks * 512 < Journal::kShotRoom / 2);
  CHECK_EQUAL(1u, strobe::testing::journal_entries(path).size());
}

using namespace strobe::firmware;

TEST_GROUP(StartOrder) {
  strobe::testing::TemporaryFolder folder;

  void add(std::int64_t boot_id) const { CHECK_TRUE(StartOrder::add(folder.path(), boot_id).has_value()); }
};

TEST(StartOrder, IsThatOfTheStarts) {
  CHECK_EQUAL(0u, StartOrder(folder.path()).position(5));
  for (const std::int64_t boot : {std::int64_t{5}, INT64_MAX, std::int64_t{3}}) add(boot);
  const StartOrder order(folder.path());
  CHECK(order.position(4) == 0 && order.position(5) > 0);
  CHECK(order.position(INT64_MAX) > order.position(5));
  CHECK(order.position(3) > order.position(INT64_MAX));
}

TEST(StartOrder, GoesOnBehindWhatAPowerCutTore) {
  add(5);
  add(6);
  const std::string whole = strobe::testing::read_text(folder / "starts");
  for (std::size_t size = 18; size < whole.size(); ++size) {
    strobe::testing::write_text(folder / "starts", whole.substr(0, size));
    add(7);
    const StartOrder order(folder.path());
    CHECK(order.position(5) > 0 && order.position(6) == 0);
    CHECK(order.position(7) > order.position(5));
  }
}

TEST(StartOrder, PassesOverWhatIsNoBoot) {
  strobe::testing::write_text(folder / "starts", std::string("\nxyz\n00000000000000zz\n\xff\n\0\n", 26) +
                                                     "0000000000000007\n000000000000000700");
  CHECK(StartOrder(folder.path()).position(7) > 0);
  CHECK_EQUAL(0u, StartOrder(folder.path()).position(0));
}

TEST(StartOrder, ReadsTheEndOfALongList) {
  std::string text;
  for (std::int64_t boot = 1; boot <= 100'000; ++boot) text += "\n" + boot_in_hex(boot);
  strobe::testing::write_text(folder / "starts", text);
  const StartOrder order(folder.path());
  CHECK_EQUAL(0u, order.position(1));
  CHECK(order.position(100'000) > order.position(99'000));
  CHECK(order.position(99'000) > 0);
  CHECK(order.position(90'000) == 0);
}
