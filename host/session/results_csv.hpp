// results.csv: one line per shot. A file grows by whole lines over any number of runs (csv_file.hpp). Writes a file; one
// thread's. The functions are pure; they allocate.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"
#include "common/shot/shot_key.hpp"
#include "host/session/csv_file.hpp"
#include "host/session/shot_result.hpp"

namespace strobe::host {

/// The columns of data_dictionary.hpp. What could not be had is empty. New columns come last and hold no commas.
std::string results_header();
inline constexpr std::string_view kResultsTitle = "Results, one row per shot";
/// Those of earlier versions, which lacked the last columns, newest first.
std::vector<std::string> earlier_results_headers();

/// Who measured the photograph: "auto" or "hand"; empty: there is none.
std::string_view digitization_word(const ShotResult& shot_result);
/// Of a shot that a person corrected afterwards.
inline constexpr std::string_view kCorrectedWord = "corrected";

/// shot_name: of shot_names.hpp. digitization: one of these words.
std::string results_line(const ShotResult& shot_result, const std::string& utc, const std::string& shot_name,
                         std::string_view digitization);

class ResultsCsv {
 public:
  /// Fails where CsvFile does.
  static Result<ResultsCsv> open(const std::filesystem::path& path);

  Result<void> add(const ShotResult& shot_result, const std::string& utc);

  std::size_t left_out() const { return file_.left_out(); }
  RecordFile& file() { return file_.file(); }
  const RecordFile& file() const { return file_.file(); }

 private:
  ResultsCsv(CsvFile file, std::vector<ShotKey> shots) : file_(std::move(file)), shots_(std::move(shots)) {}

  CsvFile file_;
  std::vector<ShotKey> shots_;  ///< of its lines: a name tells a shot from those before it
};

}  // namespace strobe::host
