// Shots and series as the page and scripts have them: see host/web/README.md. Values; pure but for
// condition_of(); thread-safe; allocates.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/data/thesis_data.hpp"
#include "common/reduction/readout.hpp"
#include "common/shot/shot_key.hpp"
#include "host/series/series.hpp"
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
  std::string surface, ball;  ///< their names in the record; empty: not stated
};

ShotRow shot_row(const host::Shot& shot);

/// {"vx_td_mps":{"value":15.4,"sd":0.19},…}: all quantities, the sd the total one; null where it is not
/// known.
nlohmann::ordered_json values_json(const reduction::Quantities& value, const reduction::Quantities& total_sd);

/// {"session","name","boot_id",…}: see host/web/README.md. session: absent: null.
nlohmann::ordered_json shot_json(const ShotRow& row, const std::optional<std::string>& session);

/// [{"name","label","unit","essential"}] in the order of reduction::Quantity.
nlohmann::ordered_json quantities_json();

/// {"summary","points","limits","thesis"}. rows: all shots of the series in the order of firing, those that
/// do not count, too; dry ones are left out. Limits: host/series/series.hpp; null where there are
/// too few shots.
nlohmann::ordered_json series_page_json(const host::SeriesSummary& summary,
                                        const std::optional<thesis::Condition>& condition,
                                        std::span<const ShotRow> rows);

/// The thesis's series where all rows have one spin and angle. Reads the file that comes with strobe.
std::optional<thesis::Condition> condition_of(std::span<const ShotRow> rows);

}  // namespace strobe::web
