// All messages of a journal, for tests.
#pragma once

#include <filesystem>
#include <vector>

#include "firmware/publisher/journal.hpp"

namespace strobe::testing {

struct PlacedEntry : firmware::JournalEntry {
  std::int64_t offset = 0;  ///< of the record in the file
};

inline std::vector<PlacedEntry> journal_entries(const std::filesystem::path& path) {
  std::vector<PlacedEntry> entries;
  wire::LogReader log(path);
  for (wire::LogRecord record; log.next(record);) {
    if (const auto entry = firmware::entry_of(record)) entries.push_back({*entry, record.offset});
  }
  return entries;
}

}  // namespace strobe::testing
