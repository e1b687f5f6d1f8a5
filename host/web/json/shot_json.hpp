// One shot as a row for the page and for scripts. Values; pure; thread-safe; allocates.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/reduction/readout.hpp"
#include "common/shot/shot_key.hpp"
#include "host/session/shot.hpp"
#include "host/session/shot_table.hpp"

namespace strobe::web {

/// What results.csv and a result have in common.
struct ShotRow {
  std::string name;  ///< Shot::name, column "shot"
  ShotKey key;
  std::string utc;  ///< when the result came
  bool dry = false;
  std::optional<std::string> rejected;  ///< why it does not count
  std::vector<std::string> flags;       ///< names, in the order of reduction::Flag
  std::string regime;                   ///< empty: not known
  std::string digitization;             ///< "auto", "hand", "corrected"; empty: none
  reduction::Quantities value, total_sd;
  std::string spin;  ///< the series' label; empty: none
  std::optional<double> angle_deg;
};

/// digitization: of host/session/shot_table.hpp or host/archive/shot_outcome.hpp.
ShotRow shot_row(const host::Shot& result, std::string name, std::string utc, std::string_view digitization);

/// Rows of a results.csv, of this version or an earlier one, in its order, each shot once; lines that are none are
/// left out.
std::vector<ShotRow> shot_rows(const std::vector<host::ResultsRow>& results);

/// {"vx_td_mps":{"value":15.4,"sd":0.19},…}: all quantities, the sd the total one; null where it is not known.
nlohmann::ordered_json values_json(const reduction::Quantities& value, const reduction::Quantities& total_sd);

/// {"session","name","boot_id",…}: see host/web/README.md. session: absent: null.
nlohmann::ordered_json shot_json(const ShotRow& row, const std::optional<std::string>& session);

/// [{"name","label","unit","essential"}] in the order of reduction::Quantity.
nlohmann::ordered_json quantities_json();

}  // namespace strobe::web
