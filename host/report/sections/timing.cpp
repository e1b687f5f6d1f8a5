// How the flashes came.
#include <fmt/format.h>

#include "host/report/sections/parts.hpp"
#include "host/report/sections/sections.hpp"

namespace strobe::lab_report {

namespace {

Cell us(const host::MeanSdMax& of, double host::MeanSdMax::*which) {
  return of.count == 0 ? Cell{"-", {}} : Cell{fmt::format("{:.1f}", of.*which), of.*which};
}

Cell seen(const std::optional<int>& count) { return count ? count_cell(*count) : Cell{"-", {}}; }

}  // namespace

Section timing(const Content& content) {
  Section section{"timing", "Timing of the flashes", {}};
  Table table{"flashes",
              "Flashes of each shot",
              {{"shot", "shot", "", false},
               {"planned", "planned", ""},
               {"issued", "issued", ""},
               {"seen_a", "seen by A", ""},
               {"seen_b", "seen by B", ""},
               {"late", "late", ""},
               {"doubled", "double", ""},
               {"lateness_mean_us", "lateness, mean", "us"},
               {"lateness_max_us", "largest", "us"},
               {"lamp_delay_mean_us", "lamp delay, mean", "us"},
               {"lamp_delay_sd_us", "its sd", "us"}},
              {},
              {"Lateness: from the commanded instant to the line's change. Late: beyond the rig's tolerance; "
               "the flash's "
               "measured time is used all the same. Lamp delay: from the line's change to the flash as its "
               "sensor saw it."}};
  for (const ReportShot& each : content.shots) {
    if (!each.shot->summary) continue;
    const host::TrainReport& train = each.shot->train;
    table.rows.push_back(
        {{text_cell(each.name), count_cell(train.planned), count_cell(train.issued), seen(train.seen_by_a),
          seen(train.seen_by_b), count_cell(train.late), count_cell(train.doubled),
          us(train.issue_lateness_us, &host::MeanSdMax::mean),
          us(train.issue_lateness_us, &host::MeanSdMax::largest),
          us(train.lamp_delay_us, &host::MeanSdMax::mean), us(train.lamp_delay_us, &host::MeanSdMax::sd)}});
  }
  if (table.rows.empty()) {
    section.blocks.emplace_back(Paragraph{"none", "No shot came to its end."});
  } else {
    section.blocks.emplace_back(std::move(table));
  }
  return section;
}

}  // namespace strobe::lab_report
