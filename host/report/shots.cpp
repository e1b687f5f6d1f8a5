// Shot by shot: in numbers, with what is wrong with it; its photograph with what was found on it; how its
// flashes came.
#include <fmt/format.h>

#include <limits>
#include <opencv2/imgproc.hpp>

#include "common/image/image_files.hpp"
#include "common/image/opencv.hpp"
#include "common/messages/lcm_conversions.hpp"
#include "host/digitize/overlay.hpp"
#include "host/photographs/measure_photograph.hpp"
#include "host/report/sections.hpp"
#include "host/session/shot.hpp"
#include "host/text/text.hpp"
#include "host/view/spatial_view.hpp"

namespace strobe::report {

namespace {

using reduction::Flag;
using reduction::Quantity;

constexpr int kJpegQuality = 78;
constexpr int kLongestSide_px = 1100;

std::vector<Flag> flags_of(const reduction::Readout& readout) {
  std::vector<Flag> flags;
  for (std::size_t i = 0; i < reduction::kFlagCount; ++i)
    if (readout.flags.has(static_cast<Flag>(i))) flags.push_back(static_cast<Flag>(i));
  return flags;
}

Table numbers_table(const Content& content, const ConditionGroup& group) {
  Table table{"numbers_" + group.key,
              "Shots: " + group.label,
              {text_column("shot"), text_column("utc", "time (UTC)"), text_column("counts")}};
  const auto quantities = quantities_of(content.input, kFewQuantities);
  for (const Quantity q : quantities) table.columns.push_back(quantity_column(q));
  for (const ReportShot& each : group.shots) {
    const auto& readout = each.shot->readout;
    Row row{{each.name, each.shot->utc, each.counts ? "yes" : "no"}, false, !each.counts};
    for (const Quantity q : quantities)
      row.cells.push_back(number_cell(readout.value[q], reduction::total_sd(readout, q)));
    table.rows.push_back(std::move(row));
  }
  return table;
}

/// What shots tell of the third dimension; without rows where none tells any.
Table spatial_table(const Content& content) {
  Table table{.key = "spatial",
              .title = "The third dimension: spin axis, velocity to the camera, place off the plane",
              .columns = {text_column("shot")},
              .notes = {"x along the travel, y up, z towards the camera; with the total standard uncertainty "
                        "of the single shot."}};
  for (std::size_t i = 0; i < reduction::kSpatialCount; ++i)
    table.columns.push_back(number_column(std::string(reduction::kSpatialNames[i]),
                                          std::string(host::kSpatialLabels[i].words),
                                          std::string(host::kSpatialLabels[i].unit)));
  for (const ReportShot& each : content.shots) {
    if (!each.shot->readout.spatial) continue;
    Row row{{each.name}, false, !each.counts};
    for (const auto& number : each.shot->readout.spatial->number)
      row.cells.push_back(number ? Cell{host::value_and_sd(number), number->value} : Cell{"-"});
    table.rows.push_back(std::move(row));
  }
  return table;
}

std::string why_not(const host::Shot& shot) {
  std::string why = shot.rejected.value_or(shot.dry ? "a dry shot, without photograph" : "");
  if (why.empty()) why = shot.summary ? "no number could be read" : "strobed ended during the shot";
  if (!shot.problem.empty() && shot.problem != why) why += "; " + shot.problem;
  return why;
}

Table rejected_table(const Content& content) {
  Table table{"rejected",
              "Shots that do not count",
              {text_column("shot"), text_column("condition"), text_column("reason")}};
  for (const ConditionGroup& group : content.conditions)
    for (const ReportShot& each : group.shots)
      if (!each.counts) table.rows.push_back({{each.name, group.label, why_not(*each.shot)}});
  return table;
}

Table flags_table(const Content& content) {
  Table table{"flags", "Flags", {text_column("flag"), text_column("words", "meaning"), text_column("shots")}};
  for (std::size_t i = 0; i < reduction::kFlagCount; ++i) {
    const auto flag = static_cast<Flag>(i);
    std::string names;
    for (const ReportShot& each : content.shots)
      if (each.shot->readout.flags.has(flag)) append(names, each.name);
    if (!names.empty()) table.rows.push_back({{reduction::name(flag), host::words(flag), names}});
  }
  return table;
}

/// Without times: there is room for the images' numbers alone.
Result<reduction::Frame> frame_of(const host::Shot& shot) {
  auto frame = messages::frame_from_lcm(shot.digitizations.back().frame);
  if (!frame) return frame;
  for (auto& image : frame->images) image.time_s = std::numeric_limits<double>::quiet_NaN();
  return frame;
}

/// Without the folder, which is none of a report's reader's business and changes where a session is moved.
std::string unreadable(const std::filesystem::path& photograph, std::string why) {
  const std::string path = photograph.string();
  if (const auto at = why.find(path); at != why.npos)
    why.replace(at, path.size(), photograph.filename().string());
  return "The photograph cannot be shown: " + why + ".";
}

/// The photograph with what was measured on it, drawn from what is stored, without measuring again. Fails
/// with why there is none, for a person.
Result<Picture> overlay_picture(const host::StoredSession& session, const host::Shot& shot) {
  if (!shot.photograph) return fail("No photograph is kept.");
  const auto photograph = digitize::load_photograph(*shot.photograph);
  if (!photograph) return fail(unreadable(*shot.photograph, photograph.error().message));
  const auto settings = host::digitize_settings(session.rig, photograph->width(), photograph->height());
  if (!settings) return fail(unreadable(*shot.photograph, settings.error().message));
  digitize::Digitization found;
  if (!shot.digitizations.empty()) {
    auto frame = frame_of(shot);
    if (!frame) return fail("The measurement cannot be shown: " + frame.error().message + ".");
    found.frame = *std::move(frame);
  }
  const cv::Mat drawn =
      digitize::draw_overlay(*photograph, settings->map, found, {.longest_side_px = kLongestSide_px});
  cv::Mat colours;
  cv::cvtColor(drawn, colours, cv::COLOR_BGR2RGB);
  auto jpeg = image::encode_jpeg(image::pixels_of(colours), kJpegQuality);
  if (!jpeg) return tl::unexpected(jpeg.error());
  return Picture{*std::move(jpeg), colours.cols, colours.rows};
}

std::vector<Fact> numbers(const reduction::Readout& readout) {
  std::vector<Fact> facts;
  for (const Quantity q : kEssential) {
    if (!readout.value[q]) continue;
    const host::QuantityLabel& label = label_of(q);
    std::string text = expanded_cell(*readout.value[q], reduction::total_sd(readout, q)).text;
    if (!label.unit.empty()) append(text, label.unit, " ");
    facts.push_back(number_fact(std::string(reduction::name(q)), std::string(label.words), *readout.value[q],
                                std::move(text)));
  }
  return facts;
}

std::vector<std::string> remarks(const ReportShot& each) {
  std::vector<std::string> out;
  const auto& result = *each.shot;
  if (result.rejected) out.push_back("Does not count: " + *result.rejected + ".");
  for (const Flag flag : flags_of(result.readout))
    out.push_back(fmt::format("{}: {}.", reduction::name(flag), host::words(flag)));
  for (std::string& sentence : host::spatial_words(result.readout)) out.push_back(std::move(sentence) + ".");
  if (!result.problem.empty()) out.push_back(result.problem);
  const auto& digitizations = each.shot->digitizations;
  if (!digitizations.empty() && digitizations.back().by_hand)
    out.push_back(digitizations.back().who.empty() ? std::string("Measured or corrected by hand.")
                                                   : "Corrected by hand: " + digitizations.back().who + ".");
  return out;
}

ShotCard card(const ReportShot& each, const std::string& condition) {
  ShotCard out;
  out.key = each.name;
  out.title = fmt::format("Shot {}, {}{}", each.name, condition, each.counts ? "" : ": does not count");
  out.counts = each.counts;
  if (auto picture = overlay_picture(*each.session, *each.shot)) {
    out.picture = *std::move(picture);
    out.facts = numbers(each.shot->readout);
  } else {
    out.no_picture = picture.error().message;
  }
  out.drawing = host::spin_drawing(each.shot->readout);
  out.remarks = remarks(each);
  return out;
}

Cell us_cell(const host::MeanSdMax& of, double host::MeanSdMax::*which) {
  if (of.count == 0) return "-";
  return {fmt::format("{:.1f}", of.*which), of.*which};
}

Cell seen_cell(const std::optional<int>& count) { return count ? count_cell(*count) : "-"; }

}  // namespace

Section shots(const Content& content) {
  Section section{"shots", "Shots"};
  for (const ConditionGroup& group : content.conditions)
    section.blocks.emplace_back(numbers_table(content, group));
  Table rejected = rejected_table(content);
  if (rejected.rows.empty()) {
    section.blocks.emplace_back(Paragraph{"none_rejected", "All shots count."});
  } else {
    section.blocks.emplace_back(std::move(rejected));
  }
  if (Table spatial = spatial_table(content); !spatial.rows.empty())
    section.blocks.emplace_back(std::move(spatial));
  if (Table flags = flags_table(content); !flags.rows.empty()) section.blocks.emplace_back(std::move(flags));
  return section;
}

Section photographs(const Content& content) {
  Section section{"photographs", "Photographs"};
  section.blocks.emplace_back(
      Paragraph{"meaning",
                "Each photograph with what was measured on it: the outlines of the ball's images with their "
                "numbers and the times of their flashes, blue before, yellow in and green after contact, "
                "magenta where a person measured; equators; orange: the surface. Numbers with the "
                "total standard uncertainty of the single shot."});
  std::size_t done = 0;
  for (const ConditionGroup& group : content.conditions) {
    for (const ReportShot& each : group.shots) {
      if (content.input.progress) content.input.progress(done++, content.shots.size(), "photographs");
      section.blocks.emplace_back(card(each, group.label));
    }
  }
  return section;
}

Section timing(const Content& content) {
  Table table{.key = "flashes",
              .title = "Flashes of each shot",
              .columns = {text_column("shot"), number_column("planned"), number_column("issued"),
                          number_column("seen_a", "seen by A"), number_column("seen_b", "seen by B"),
                          number_column("late"), number_column("doubled", "double"),
                          number_column("lateness_mean_us", "lateness, mean", "us"),
                          number_column("lateness_max_us", "largest", "us"),
                          number_column("lamp_delay_mean_us", "lamp delay, mean", "us"),
                          number_column("lamp_delay_sd_us", "its sd", "us")},
              .notes = {"Lateness: from the commanded instant to the line's change. Late: beyond the rig's "
                        "tolerance; the flash's measured time is used all the same. Lamp delay: from the "
                        "line's change to the flash as its sensor saw it."}};
  using host::MeanSdMax;
  for (const ReportShot& each : content.shots) {
    if (!each.shot->summary) continue;
    const host::TrainReport& train = each.shot->train;
    table.rows.push_back(
        {{each.name, count_cell(train.planned), count_cell(train.issued), seen_cell(train.seen_by_a),
          seen_cell(train.seen_by_b), count_cell(train.late), count_cell(train.doubled),
          us_cell(train.issue_lateness_us, &MeanSdMax::mean),
          us_cell(train.issue_lateness_us, &MeanSdMax::largest),
          us_cell(train.lamp_delay_us, &MeanSdMax::mean), us_cell(train.lamp_delay_us, &MeanSdMax::sd)}});
  }
  Section section{"timing", "Timing of the flashes"};
  if (table.rows.empty()) {
    section.blocks.emplace_back(Paragraph{"none", "No shot came to its end."});
  } else {
    section.blocks.emplace_back(std::move(table));
  }
  return section;
}

}  // namespace strobe::report
