#include "tests/soak/disk.hpp"

#include <strobe_msgs/event_t.hpp>

#include "firmware/publisher/journal.hpp"
#include "tests/support/journal_entries.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::soak;

namespace {

std::vector<firmware::Message> event(std::int64_t sequence) {
  strobe_msgs::event_t message{};
  message.schema_version = strobe_msgs::event_t::SCHEMA_VERSION;
  message.boot_id = 5;
  message.sequence = sequence;
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return {{firmware::Message::Kind::event, {sequence, sequence}, "STROBE/bench/EVENT", bytes}};
}

}  // namespace

TEST_GROUP(VirtualDisk){};

TEST(VirtualDisk, CutsAWriteShortWhereItIsFullAndTakesItWhenThereIsRoomAgain) {
  VirtualDisk disk;
  auto journal = firmware::Journal::create(disk.path(), 5);
  CHECK_TRUE(journal.has_value());
  CHECK_TRUE(journal->append(event(1), 0).has_value());
  for (const std::uint64_t room : {0, 10, 100}) {  // less than an event takes
    disk.fill(room);
    CHECK_TRUE(disk.full());
    bool done = true;
    disk.write([&] { done = journal->append(event(2), 0).has_value(); });
    CHECK_FALSE(done);
    LONGS_EQUAL(1, testing::journal_entries(journal->path()).size());
  }
  disk.make_room();
  disk.write([&] { CHECK_TRUE(journal->append(event(2), 0).has_value()); });
  LONGS_EQUAL(2, testing::journal_entries(journal->path()).size());
}

TEST(VirtualDisk, KeepsWhatWasWrittenAfterItsWriterHasEnded) {
  VirtualDisk disk;
  {
    auto journal = firmware::Journal::create(disk.path(), 5);
    CHECK_TRUE(journal->append(event(1), 0).has_value());
  }
  LONGS_EQUAL(1, testing::journal_entries(firmware::journal_path(disk.path(), 5)).size());
}

TEST(VirtualDisk, LeavesNothingBehind) {
  std::filesystem::path path;
  {
    const VirtualDisk disk;
    path = disk.path();
    CHECK_TRUE(std::filesystem::is_directory(path));
  }
  CHECK_FALSE(std::filesystem::exists(path));
}
