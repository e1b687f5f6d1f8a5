#include "firmware/publisher/journal.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <lcm/lcm-cpp.hpp>
#include <optional>
#include <string>

#include "firmware/publisher/journal_folder.hpp"
#include "tests/firmware/journal_messages.hpp"
#include "tests/support/journal_entries.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::firmware;

namespace {

using namespace strobe::journal_test;

std::vector<std::string> channels_in(const std::filesystem::path& path) {
  std::vector<std::string> channels;
  lcm::LogFile log(path.string(), "r");
  while (const lcm::LogEvent* record = log.readNextEvent()) channels.push_back(record->channel);
  return channels;
}

/// Files of this process cannot grow beyond, as if the disk were full: a write is cut short, the next one
/// fails.
class FullDisk {
 public:
  explicit FullDisk(std::uintmax_t size) {
    before_ = signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &limit_);
    const rlimit tight{size, limit_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &tight);
  }
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &limit_);
    signal(SIGXFSZ, before_);
  }

 private:
  rlimit limit_{};
  void (*before_)(int) = nullptr;
};

}  // namespace

TEST_GROUP(Journal) { strobe::testing::TemporaryFolder folder; };

TEST(Journal, IsALogThatLcmReads) {
  auto journal = Journal::create(folder / "new" / "session", kBoot);
  CHECK_TRUE(journal.has_value());
  CHECK(journal->append({event(1), event(2), shot(1, {1, 2})}, 1'700'000'000'000'000).has_value());
  CHECK_EQUAL(std::string("journal-1122334455667788.lcmlog"), journal->path().filename().string());
  lcm::LogFile log(journal->path().string(), "r");
  for (std::int64_t k = 0; k < 2; ++k) {
    const lcm::LogEvent* record = log.readNextEvent();
    CHECK_EQUAL(k, record->eventnum);
    CHECK_EQUAL(1'700'000'000'000'000, record->timestamp);
    strobe_msgs::event_t message;
    CHECK(message.decode(record->data, 0, record->datalen) > 0);
    CHECK_EQUAL(k + 1, message.sequence);
    CHECK_EQUAL(std::string("words"), message.detail);
  }
  CHECK_EQUAL(std::string("STROBE/bench/SHOT"), log.readNextEvent()->channel);
  POINTERS_EQUAL(nullptr, log.readNextEvent());
}

TEST(Journal, CanBeReadWhileItIsWritten) {
  auto journal = Journal::create(folder.path(), kBoot);
  wire::LogReader reader(journal->path());
  wire::LogRecord record;
  CHECK_FALSE(reader.next(record));
  for (std::int64_t k = 1; k <= 3; ++k) {
    CHECK(journal->append({event(k)}, 0).has_value());
    CHECK_TRUE(reader.next(record));
    CHECK_EQUAL(event(k).bytes, record.bytes);
    CHECK_FALSE(reader.next(record));
  }
}

TEST(Journal, IsInOrderOfItsMessagesLastSequences) {
  auto journal = Journal::create(folder.path(), kBoot);
  CHECK(journal->append({event(1)}, 0).has_value());
  CHECK(journal->append({event(2, 7), shot(7, {1, 2}), event(3)}, 0).has_value());
  const auto entries = strobe::testing::journal_entries(journal->path());
  CHECK_EQUAL(4u, entries.size());
  CHECK_EQUAL(7, entries[1].shot_id);
  CHECK_EQUAL(7, entries[2].shot_id);
  CHECK(entries[2].kind == Message::Kind::shot);
  CHECK(entries[2].sequences == SequenceRange({1, 2}));
  CHECK_EQUAL(3, entries[3].sequences.last);
}

TEST(Journal, IsReadUpToATornTailAndUpToZeros) {
  auto journal = Journal::create(folder.path(), kBoot);
  CHECK(journal->append({event(1), event(2), shot(5, {1, 2})}, 0).has_value());
  const auto whole = strobe::testing::read_text(journal->path());
  const auto last = static_cast<std::size_t>(strobe::testing::journal_entries(journal->path())[2].offset);
  for (std::size_t size = last; size < whole.size(); size += 7) {
    for (const std::size_t zeros :
         {0, 1, 100}) {  // what a file system may leave of a write that was under way
      strobe::testing::write_text(journal->path(), whole.substr(0, size) + std::string(zeros, '\0'));
      CHECK(strobe::testing::journal_entries(journal->path()).size() == 2 || zeros > 0);
      CHECK(strobe::testing::journal_entries(journal->path()).size() >= 2);
    }
  }
}

TEST(Journal, IsReadOnAfterADamagedStretch) {
  auto journal = Journal::create(folder.path(), kBoot);
  CHECK(journal->append({event(1), event(2), event(3), shot(5, {1, 3})}, 0).has_value());
  auto text = strobe::testing::read_text(journal->path());
  text.replace(static_cast<std::size_t>(strobe::testing::journal_entries(journal->path())[1].offset), 40,
               std::string(40, '\0'));
  strobe::testing::write_text(journal->path(), text);
  const auto entries = strobe::testing::journal_entries(journal->path());
  CHECK_EQUAL(3u, entries.size());
  CHECK_EQUAL(3, entries[1].sequences.first);
}

TEST(Journal, PassesOverRecordsThatAreNoMessagesOfItsOwn) {
  auto journal = Journal::create(folder.path(), kBoot);
  Message torn_event = event(2), torn_shot = shot(1, {1, 2}), other = event(3);
  torn_event.bytes.pop_back();
  torn_shot.bytes.pop_back();
  other.channel = "STROBE/bench/STATUS";
  CHECK(journal->append({event(1), torn_event, torn_shot, other}, 0).has_value());
  CHECK_EQUAL(1u, strobe::testing::journal_entries(journal->path()).size());
}

TEST(Journal, NeverOverwritesAnother) {
  CHECK_TRUE(Journal::create(folder.path(), kBoot).has_value());
  const auto second = Journal::create(folder.path(), kBoot);
  CHECK_FALSE(second.has_value());
  STRCMP_CONTAINS("journal-1122334455667788.lcmlog: the journal cannot be made: File exists",
                  second.error().message.c_str());
}

TEST(Journal, CutsOffAHalfWrittenEndAndGoesOnLater) {
  auto journal = Journal::create(folder.path(), kBoot);
  CHECK(journal->append({event(1)}, 0).has_value());
  const auto size = std::filesystem::file_size(journal->path());
  {
    const FullDisk disk(size + 50);  // less than one more event
    const auto failed = journal->append({event(2), event(3)}, 0);
    CHECK_FALSE(failed.has_value());
    STRCMP_CONTAINS("File too large", failed.error().message.c_str());
  }
  CHECK_EQUAL(size, std::filesystem::file_size(journal->path()));
  CHECK_EQUAL(1u, channels_in(journal->path()).size());
  CHECK(journal->append({event(2), event(3)}, 0).has_value());
  CHECK_EQUAL(3u, channels_in(journal->path()).size());
}

/// A journal with one event in a folder of its own, and what is wrong with it now.
struct Underneath {
  strobe::testing::TemporaryFolder parent;
  std::filesystem::path folder = parent / "session";
  Result<Journal> journal = Journal::create(folder, kBoot);

  Underneath() {
    CHECK(journal->append({event(1)}, 0).has_value());
    CHECK(journal->check().has_value());
  }
  std::string fault() const {
    const auto checked = journal->check();
    return checked ? "" : checked.error().message;
  }
};

TEST(Journal, NoticesThatItsFileOrItsFolderWasRemoved) {
  Underneath file;
  std::filesystem::remove(file.journal->path());
  STRCMP_CONTAINS("the journal was removed; restart strobed", file.fault().c_str());
  Underneath whole;
  std::filesystem::remove_all(whole.folder);
  STRCMP_CONTAINS("the journal was removed", whole.fault().c_str());
}

TEST(Journal, NoticesThatItsFolderWasRenamedAndThatItIsBack) {
  Underneath journal;
  std::filesystem::rename(journal.folder, journal.parent / "elsewhere");
  STRCMP_CONTAINS("the journal was moved away (No such file or directory); put it back",
                  journal.fault().c_str());
  std::filesystem::rename(journal.parent / "elsewhere", journal.folder);
  CHECK_EQUAL("", journal.fault());
}

TEST(Journal, NoticesThatItWasRotated) {
  Underneath moved;
  std::filesystem::rename(moved.journal->path(), moved.journal->path().string() + ".1");
  STRCMP_CONTAINS("the journal was moved away", moved.fault().c_str());
  strobe::testing::write_text(moved.journal->path(), "");
  STRCMP_CONTAINS("another file is in the journal's place", moved.fault().c_str());
  Underneath copied;  // and its contents cut off
  std::filesystem::resize_file(copied.journal->path(), 0);
  STRCMP_CONTAINS("the journal was changed by another program", copied.fault().c_str());
}

TEST(Journal, NoticesThatItsFolderCannotBeWritten) {
  Underneath journal;
  std::filesystem::permissions(journal.parent.path(), std::filesystem::perms(0755));
  std::filesystem::permissions(journal.folder, std::filesystem::perms(0555));
  const bool is_root = geteuid() == 0;
  if (is_root && seteuid(65534) != 0) return;  // to whom no folder is read-only
  const std::string fault = journal.fault();
  if (is_root) CHECK_EQUAL(0, seteuid(0));
  STRCMP_CONTAINS("the folder cannot be written: Permission denied", fault.c_str());
  std::filesystem::permissions(journal.folder, std::filesystem::perms(0755));
  CHECK_EQUAL("", journal.fault());
}

TEST(Journal, SaysBeforeAShotThatThereIsNoRoomForIt) {
  auto journal = Journal::create(folder.path(), kBoot);
  CHECK(journal->append({event(1)}, 0).has_value());
  {
    const FullDisk disk(static_cast<std::uintmax_t>(Journal::kShotRoom));
    const auto room = journal->make_room();
    CHECK_FALSE(room.has_value());
    STRCMP_CONTAINS("no room for another shot: File too large", room.error().message.c_str());
    CHECK(journal->append({event(2)}, 0).has_value());  // what there is room for is still written
  }
  CHECK(journal->make_room().has_value());
}

TEST(Journal, GivesNoShotRoomBeforeItsStartIsListed) {
  std::optional<Result<Journal>> journal;
  {
    const FullDisk disk(0);
    journal.emplace(Journal::create(folder.path(), kBoot));
  }
  CHECK_TRUE(journal->has_value());
  CHECK_EQUAL(0u, StartOrder(folder.path()).position(kBoot));
  std::filesystem::remove(folder / "starts");
  std::filesystem::create_directory(folder / "starts");  // nobody can write there
  const auto failed = (*journal)->make_room();
  CHECK_FALSE(failed.has_value());
  STRCMP_CONTAINS("starts: this start cannot be listed: Is a directory", failed.error().message.c_str());
  std::filesystem::remove(folder / "starts");
  CHECK((*journal)->make_room().has_value());
  CHECK_EQUAL(1u, StartOrder(folder.path()).position(kBoot));
}

TEST(Journal, TakesNoMoreOfTheDiskThanItHoldsOnceItIsClosed) {
  std::filesystem::path path;
  {
    auto journal = Journal::create(folder.path(), kBoot);
    path = journal->path();
    CHECK(journal->make_room().has_value());
    CHECK(journal->append({event(1)}, 0).has_value());
    CHECK_EQUAL(1u, strobe::testing::journal_entries(path).size());  // room is none of the file's size
  }
  struct stat file {};
  CHECK_EQUAL(0, stat(path.c_str(), &file));
  CHECK(file.st_blocks * 512 < Journal::kShotRoom);
}
