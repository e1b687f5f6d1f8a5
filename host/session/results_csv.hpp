// results.csv: one line per shot (csv_file.hpp writes it). Pure functions; thread-safe; they allocate.
#pragma once

#include <string>

#include "host/session/session.hpp"

namespace strobe::host {

/// Columns: utc, boot_id (hex), shot_id, rejected (why, else empty), each quantity, sd_<quantity>,
/// sd_systematic_<quantity>, regime, court_pace_conforming, method, mirrored, flags (separated by ;), the
/// named notes of notes.hpp, other_notes (key=value separated by ;), first_flash, last_flash, misassignment_probability
/// (ImagedFlashes). What could not be had is empty. New columns come last and hold plain numbers.
std::string results_header();
/// As it was before first_flash.
std::string earlier_results_header();
std::string results_line(const ShotResult& shot_result, const std::string& utc);

}  // namespace strobe::host
