// Each shot's photograph with what was found on it.
#include <fmt/format.h>

#include "host/report/content/overlay_picture.hpp"
#include "host/report/sections/parts.hpp"
#include "host/report/sections/sections.hpp"
#include "host/session/shot.hpp"
#include "host/text/text.hpp"

namespace strobe::lab_report {

namespace {

using reduction::Quantity;

constexpr int kLongestSide_px = 1100;

std::vector<Fact> numbers(const reduction::Readout& readout) {
  std::vector<Fact> facts;
  for (const Quantity q : kEssential) {
    if (!readout.value[q]) continue;
    const host::QuantityLabel& label = label_of(q);
    const auto& sd = readout.sd[q];
    std::string text = number_cell(readout.value[q], sd).text;
    if (sd && *sd > 0.0) text += " ± " + host::rounded(*sd, *sd);
    facts.push_back(number_fact(std::string(reduction::name(q)), std::string(label.words), *readout.value[q],
                                text + (label.unit.empty() ? "" : " " + std::string(label.unit))));
  }
  return facts;
}

std::vector<std::string> remarks(const ReportShot& each) {
  std::vector<std::string> out;
  const auto& result = *each.shot;
  if (result.rejected) out.push_back("Does not count: " + *result.rejected + ".");
  for (std::size_t i = 0; i < reduction::kFlagCount; ++i) {
    const auto flag = static_cast<reduction::Flag>(i);
    if (result.readout.flags.has(flag))
      out.push_back(fmt::format("{}: {}.", reduction::name(flag), host::words(flag)));
  }
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
  auto picture = overlay_picture(*each.session, *each.shot, kLongestSide_px);
  if (picture) {
    out.picture = *std::move(picture);
  } else {
    out.no_picture = picture.error().message;
  }
  if (out.picture) out.facts = numbers(each.shot->readout);
  out.remarks = remarks(each);
  return out;
}

}  // namespace

Section photographs(const Content& content) {
  Section section{"photographs", "Photographs", {}};
  section.blocks.emplace_back(
      Paragraph{"meaning",
                "Each photograph with what was measured on it: the outlines of the ball's images with their "
                "numbers and the times of "
                "their flashes, blue before, yellow in and green after contact, magenta where a person "
                "measured; equators; orange: the "
                "surface. Numbers with their sd for the single shot, given the ball's diameter."});
  std::size_t done = 0;
  for (const ConditionGroup& group : content.conditions) {
    for (const ReportShot& each : group.shots) {
      if (content.input.progress) content.input.progress(done++, content.shots.size(), "photographs");
      section.blocks.emplace_back(card(each, group.label));
    }
  }
  return section;
}

}  // namespace strobe::lab_report
