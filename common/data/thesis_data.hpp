// The thesis's data: means of its 21 conditions (Tables 2–10) and the contact images of each (Appendix), as
// printed, and a separate list of corrections, each with its reason, applied on loading by default; and what
// is known of its other tables. Parsing is pure; load functions read files. Thread-safe; allocates.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/data/contact_set.hpp"
#include "common/result.hpp"

namespace strobe::thesis {

enum class Version { corrected, as_printed };

/// One line of corrections.csv. `table` is "tables_02_to_10" or "contact" for the shipped data; lines about
/// other tables of the thesis are documentation and change nothing.
struct Correction {
  std::string set;  ///< e.g. "zero_23"
  std::string table;
  std::string row;        ///< contact: the printed time fraction, or "all"
  std::string field;      ///< a column; or "row"
  std::string printed;    ///< compared with the data before it is replaced; may be empty
  std::string corrected;  ///< a number, "exclude", "negate" or "sort"
  std::string reason;
  int line = 0;
};

struct MeanSd {
  double mean = 0.0;
  double sd = 0.0;  ///< population standard deviation
};

/// Means over the replicates of one angle of incidence and spin.
struct Condition {
  std::string spin;  ///< "zero", "top", "back"
  int angle_label_deg = 0;
  int n_incoming = 0;
  int n_rebound = 0;
  int n_system = 0;
  MeanSd theta_in_deg, vx_td_mps, vy_td_mps, v_td_mps, omega_td_radps;
  MeanSd theta_out_deg, vx_lo_mps, vy_lo_mps, v_lo_mps, omega_lo_radps;
  MeanSd e, mu, dwell_distance_cm, dwell_time_ms;

  std::string name() const { return spin + "_" + std::to_string(angle_label_deg); }
};

struct Data {
  std::vector<Condition> conditions;                ///< in printed order: zero, top, back, by angle
  std::map<std::string, data::ContactSet> contact;  ///< by name, e.g. "zero_23"
  std::vector<Correction> corrections;

  const Condition* condition(std::string_view name) const;  ///< nullptr if there is none of that name
};

Result<std::vector<Correction>> parse_corrections(std::string_view text, std::string_view source);

/// tables_02_to_10.csv as printed.
Result<std::vector<Condition>> parse_conditions(std::string_view text, std::string_view source);

/// Applies the corrections of the conditions or of the set. Fails when a correction's set, row, field or
/// printed value is not in the data: the list and the data do not belong together.
Result<std::vector<Condition>> corrected(std::vector<Condition> conditions,
                                         std::span<const Correction> corrections);
Result<data::ContactSet> corrected(data::ContactSet set, std::span<const Correction> corrections);

/// The condition of that spin and that angle of incidence (which the tables label without sign) as it comes
/// with the programs, as printed. Reads a file. Returns nullopt if there is none, or no such file.
std::optional<Condition> shipped_condition(const std::string& spin, double angle_deg);

/// Reads `folder`/tables_02_to_10.csv, `folder`/corrections.csv and `folder`/contact/<name>.csv for each
/// condition.
Result<Data> load(const std::filesystem::path& folder, Version version);

/// A number that the thesis prints beyond its Tables 2–10, with where it is known from.
struct PrintedValue {
  std::string table;  ///< "15", or the name of a source that the thesis cites
  std::string set;    ///< e.g. "zero_23"
  std::string quantity;
  std::string unit;
  double value = 0.0;
  double last_digit = 1.0;  ///< unit of the last digit printed: 0.001 for 1.070
  std::string provenance;
};

/// Columns table,set,quantity,unit,value,provenance.
Result<std::vector<PrintedValue>> parse_printed_values(std::string_view text, std::string_view source);

/// Reads `folder`/printed_values.csv.
Result<std::vector<PrintedValue>> load_printed_values(const std::filesystem::path& folder);

/// Returns nullptr if there is none.
const PrintedValue* find(std::span<const PrintedValue> values, std::string_view table, std::string_view set,
                         std::string_view quantity);

}  // namespace strobe::thesis
