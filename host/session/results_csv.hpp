// results.csv: one line per shot (csv_file.hpp writes it). Pure functions; thread-safe; they allocate.
#pragma once

#include <string>

#include "host/session/session.hpp"

namespace strobe::host {

/// The columns of data_dictionary.hpp. What could not be had is empty. New columns come last and hold plain numbers.
std::string results_header();
/// As it was before first_flash.
std::string earlier_results_header();
std::string results_line(const ShotResult& shot_result, const std::string& utc);

}  // namespace strobe::host
