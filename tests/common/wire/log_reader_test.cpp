#include "common/wire/log_reader.hpp"

#include <string>

#include "tests/support/temporary_folder.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::wire;

namespace {

std::string big_endian(std::uint64_t value, int bytes) {
  std::string text;
  for (int shift = 8 * (bytes - 1); shift >= 0; shift -= 8) text += static_cast<char>(value >> shift & 0xff);
  return text;
}

std::string record(std::size_t channel, std::size_t data, std::int64_t wall_us = 0) {
  return big_endian(kLogSyncWord, 4) + big_endian(0, 8) + big_endian(static_cast<std::uint64_t>(wall_us), 8) +
         big_endian(channel, 4) + big_endian(data, 4) + std::string(channel, 'c') + std::string(data, 'd');
}

}  // namespace

TEST_GROUP(LogReader) {
  strobe::testing::TemporaryFolder folder;
  LogRecord found;

  bool reads(const std::string& bytes) {
    strobe::testing::write_text(folder / "log", bytes);
    return LogReader(folder / "log").next(found);
  }
};

TEST(LogReader, GivesTimeChannelAndBytes) {
  CHECK_TRUE(reads(record(3, 2, 0x1122334455667788)));
  CHECK_EQUAL(0x1122334455667788, found.wall_us);
  CHECK_EQUAL(std::string("ccc"), found.channel);
  CHECK_EQUAL(2u, found.bytes.size());
}

TEST(LogReader, TakesNoLengthsThatOnlyDamageMakes) {
  constexpr std::size_t kLargest = LogReader::kLargestMessage_bytes;
  CHECK_TRUE(reads(record(1000, kLargest)));
  CHECK_FALSE(reads(record(1000, kLargest + 1)));
  CHECK_FALSE(reads(record(1001, 1)));
  CHECK_FALSE(reads(record(0, 1)));
  CHECK_TRUE(reads(record(1, 0)));
}

TEST(LogReader, FindsARecordWhereverTheDamageBeforeItEnds) {
  for (std::size_t damaged = 65'530; damaged <= 65'540; ++damaged) {  // it looks through 16 KiB at once
    CHECK_TRUE(reads(std::string(damaged, '\0') + record(1, 1)));
    CHECK_EQUAL(static_cast<std::int64_t>(damaged), found.offset);
  }
}
