// A journal is read again after anything may have happened to it: any bytes in its folder are read to their
// end, mended once, and then found whole; ranges of events are found in bounded steps, and nothing else is given.
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include "common/wire/log_reader.hpp"
#include "firmware/publisher/journal_folder.hpp"
#include "firmware/publisher/resend.hpp"
#include "tests/fuzz/require.hpp"

using namespace strobe::fuzz;

namespace {

/// In memory, of this process alone.
std::filesystem::path folder() {
  const std::filesystem::path path = "/dev/shm/strobe-fuzz-" + std::to_string(getpid());
  std::filesystem::create_directories(path);
  return path;
}

int records_of(const std::filesystem::path& path, std::size_t size) {
  strobe::wire::LogReader reader(path);
  strobe::wire::LogRecord record;
  int records = 0;
  while (reader.next(record)) {
    ++records;
    require(record.channel.size() + record.bytes.size() <= size);
    require(reader.at() > record.offset && reader.at() <= static_cast<std::int64_t>(size));
  }
  return records;
}

/// Whatever the bytes, a search ends: each step reads on, or halves what is left.
void read_range(const std::filesystem::path& path, std::size_t size, const strobe::SequenceRange& wanted) {
  using strobe::firmware::RangeReader;
  RangeReader reader(path, wanted);
  strobe::wire::LogRecord record;
  const std::size_t most = 64 * (size + 64);
  std::size_t steps = 0;
  for (RangeReader::Step step{}; step != RangeReader::Step::done; ++steps) {
    require(steps < most);
    step = reader.step(record);
    if (step != RangeReader::Step::message) continue;
    const auto entry = strobe::firmware::entry_of(record);
    require(entry && entry->sequences.first <= wanted.last && entry->sequences.last >= wanted.first);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::filesystem::path dir = folder();
  const std::filesystem::path path = dir / "journal-0000000000000007.lcmlog";
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  records_of(path, size);
  for (const std::int64_t first : {std::int64_t{1}, std::int64_t{3}, std::int64_t{1} << 40})
    read_range(path, size, {first, first + 5});
  const auto first = strobe::firmware::repair_journals(dir);
  for (const std::string& line : first.repaired) require(!line.empty() && line.size() <= 160);
  std::error_code error;
  const auto left = std::filesystem::file_size(path, error);
  require(error || left <= size);
  const auto second = strobe::firmware::repair_journals(dir);
  require(second.last_shot_id == first.last_shot_id && second.earlier == first.earlier);
  return 0;
}
