// How it was measured and what is different from the method.
#include <fmt/format.h>

#include <map>

#include "host/report/sections/parts.hpp"
#include "host/report/sections/sections.hpp"

namespace strobe::lab_report {

namespace {

std::string flights(const Content& content) {
  std::map<std::string, int> methods;
  for (const ReportShot& each : content.shots)
    if (each.counts) ++methods[each.shot->readout.method];
  std::string out;
  for (const auto& [method, count] : methods)
    out += fmt::format("{}{} ({} shots)", out.empty() ? "" : ", ", method, count);
  return out.empty() ? "none" : out;
}

/// What the session itself shows to be other than planned.
std::vector<std::string> seen_deviations(const Content& content) {
  std::vector<std::string> out;
  int by_hand = 0, rejected = 0;
  for (const ReportShot& each : content.shots) {
    if (!each.shot->digitizations.empty() && each.shot->digitizations.back().by_hand) ++by_hand;
    if (!each.counts) ++rejected;
  }
  if (by_hand > 0)
    out.push_back(fmt::format("{} of {} photographs were measured or corrected by hand.", by_hand,
                              content.shots.size()));
  if (rejected > 0)
    out.push_back(fmt::format("{} of {} shots do not count; the reasons are given with the shots.", rejected,
                              content.shots.size()));
  for (const auto& session : content.input.sessions)
    for (const std::string& remark : session.remarks) out.push_back(remark);
  return out;
}

}  // namespace

Section method(const Content& content) {
  Section section{"method", "Method", {}};
  Facts facts{"method", "", {}};
  facts.facts = {stated_fact("method", "Method", content.stated("method")),
                 fact("principle", "Principle",
                      "Stroboscopic photographs of the ball before, in and after contact; times of the "
                      "flashes by sensors; least "
                      "squares over all images of both legs, with gravity, drag and lift where they matter. "
                      "Thesis on the impact "
                      "dynamics of a tennis ball striking a hard surface (Oregon State University); "
                      "common/reduction/README.md of "
                      "strobe " +
                          content.input.version + "."),
                 fact("estimator", "Estimator", flights(content)),
                 fact("uncertainty", "Uncertainty",
                      "JCGM 100:2008 (GUM). What all shots share (scale, ball, air, calibration) does not "
                      "become smaller with their "
                      "number; degrees of freedom by Welch and Satterthwaite; coverage 95 %."),
                 stated_fact("deviations", "Deviations from the method", content.stated("deviations"))};
  section.blocks.emplace_back(std::move(facts));
  int number = 0;
  for (std::string& words : seen_deviations(content))
    section.blocks.emplace_back(Paragraph{fmt::format("deviation_{}", ++number), std::move(words)});
  return section;
}

}  // namespace strobe::lab_report
