// Logs of hosts that wrote at once, and damaged ones, read as one.
#include "host/archive/stored_logs.hpp"

#include <fstream>
#include <string>
#include <vector>

#include "host/session/session_logs.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;

void write(const std::filesystem::path& folder, const std::string& utc,
           const std::vector<std::pair<int, std::string>>& messages) {
  // 2026-01-31 09:30:00 UTC (date -u -d @1769851800)
  constexpr WallTime kStart{milliseconds{1'769'851'800'000}};
  auto log = host::EventLog::create(folder, utc);
  for (const auto& [second, channel] : messages) {
    const std::vector<std::uint8_t> bytes(40, static_cast<std::uint8_t>(second));
    CHECK_TRUE(log->append(channel, bytes, kStart + std::chrono::seconds{second}).has_value());
  }
}

std::string channels(host::StoredLogs& logs) {
  std::string text;
  while (const auto message = logs.next()) text += message->channel;
  return text;
}

}  // namespace

TEST_GROUP(LogsOfASession) { testing::TemporaryFolder folder; };

TEST(LogsOfASession, AreInOrderOfTime) {
  write(folder.path(), "20260131T093000Z", {{0, "a"}, {3, "d"}, {9, "f"}});
  write(folder.path(), "20260131T093001Z", {{1, "b"}, {2, "c"}, {4, "e"}});
  write(folder.path(), "20260131T093010Z", {{20, "g"}});
  auto logs = host::StoredLogs::open(host::host_logs(folder.path()));
  CHECK_EQUAL("abcdefg", channels(*logs));
  LONGS_EQUAL(7, logs->messages());
  LONGS_EQUAL(0, logs->remarks().size());
  DOUBLES_EQUAL(1.0, logs->share(), 0.0);
}

TEST(LogsOfASession, AClockThatWasSetBackKeepsALogsOwnOrder) {
  write(folder.path(), "20260131T093000Z", {{5, "a"}, {1, "b"}, {6, "c"}});
  auto logs = host::StoredLogs::open(host::host_logs(folder.path()));
  CHECK_EQUAL("abc", channels(*logs));
}

TEST(LogsOfASession, DamageHidesNoRecordBehindIt) {
  write(folder.path(), "20260131T093000Z", {{1, "a"}, {2, "b"}, {3, "c"}});
  const auto path = host::host_logs(folder.path()).front();
  {
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(28 + 1 + 40);  // the second record's sync word
    file << "junk";
  }
  auto logs = host::StoredLogs::open({path});
  CHECK_EQUAL("ac", channels(*logs));
  LONGS_EQUAL(1, logs->remarks().size());
  STRCMP_CONTAINS("host-20260131T093000Z.lcmlog: 69 of 207 bytes", logs->remarks().front().c_str());
}

TEST(LogsOfASession, OneThatIsNotThereIsNamed) {
  STRCMP_CONTAINS("/nowhere/host-1.lcmlog: no such file",
                  host::StoredLogs::open({"/nowhere/host-1.lcmlog"}).error().message.c_str());
}
