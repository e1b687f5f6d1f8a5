// One shot of a batch: measured again from its stored photograph, at its own flashes' times, and reduced.
// Reads the photograph; thread-safe; allocates.
#pragma once

#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "common/result.hpp"
#include "host/archive/read_session.hpp"
#include "host/batch/batch_tables.hpp"
#include "host/session/shot_table.hpp"

namespace strobe::host {

/// Where a row's numbers come from.
enum class RowSource { photograph, stored_frame, none };

/// What a shot's row is made of, before it is measured. shot: with the batch's rig.
struct BatchShot {
  const Shot* shot = nullptr;
  RowSource source = RowSource::none;
  std::string corrections;  ///< a person's, of the newest digitization; applied to what is found again
};

/// Fails if corrections cannot be read.
Result<BatchShot> batch_shot(const Shot& shot, const BatchSettings& settings);

/// Of all that the row depends on. photograph_hash: of the photograph's bytes; empty: it is not used.
std::string row_key(const BatchShot& shot, const BatchSettings& settings, const std::string& photograph_hash);

/// What a finished row keeps; what can be had from the session is left out.
struct BatchRow {
  std::string results;  ///< as a line of results.csv
  bool failed = false;  ///< the photograph could not be measured: `rejected` says why
};

BatchRow measure(const BatchShot& shot, const BatchSettings& settings);

/// Of a shot that cannot be measured.
BatchRow failed_row(const Shot& shot, const std::string& why);

/// Of a batch's tables: results_columns(), and session, photograph, digitized, key, batch.
std::vector<Column> batch_columns();
std::string_view name(RowSource source);

// Finished rows of a batch, one JSON object a line: done.jsonl, or of a part on one of several machines
// done-2-of-8.jsonl. A row is on the disk before it counts as finished; what a kill cut short at the end is
// removed. Writes a file that only one process has open at a time; thread-safe.

/// A photograph as it was when its bytes were hashed.
struct PhotographStamp {
  std::string path;
  std::int64_t size = 0;
  std::int64_t changed_ns = 0;
  std::string hash;
};

class BatchJournal {
 public:
  /// Reads all journals of the folder, opens `name` for appending. Fails if another batch has it open.
  static Result<std::unique_ptr<BatchJournal>> open(const std::filesystem::path& folder,
                                                    const std::string& name);
  ~BatchJournal();
  BatchJournal(const BatchJournal&) = delete;
  BatchJournal& operator=(const BatchJournal&) = delete;

  std::optional<BatchRow> find(const std::string& key) const;
  /// The hash of a photograph that has not changed since; hashed anew else. Fails if it cannot be read.
  Result<PhotographStamp> stamp(const std::filesystem::path& photograph) const;
  /// Fails with the file's name if the row is not on the disk.
  Result<void> add(const std::string& key, const BatchRow& row,
                   const std::optional<PhotographStamp>& photograph);

 private:
  BatchJournal() = default;
  Result<void> load(const std::filesystem::path& path, bool own);
  bool load_line(const std::string& line);

  mutable std::mutex mutex_;
  std::filesystem::path path_;
  int fd_ = -1;
  std::unordered_map<std::string, BatchRow> rows_;
  std::map<std::string, PhotographStamp> stamps_;
};

}  // namespace strobe::host
