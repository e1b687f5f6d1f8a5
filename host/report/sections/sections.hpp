// The parts of a report, in their order. All but commissioning(), photographs() and records(), which read the session's files, are pure;
// thread-safe.
#pragma once

#include "host/report/content/content.hpp"
#include "host/report/model/model.hpp"

namespace strobe::lab_report {

/// Who, for whom, what, when; who signs.
Section identification(const Content& content, const std::string& issued);
/// Against limits and the court pace test.
Section conformity(const Content& content);
/// Means with expanded uncertainties, by the thesis's tables.
Section results(const Content& content);
/// How it was measured, what the uncertainty means, deviations.
Section method(const Content& content);
/// Rig, ball, camera and its calibration, runs.
Section set_up(const Content& content);
/// What proved the rig: the record of commissioning that the session keeps.
Section commissioning(const Content& content);
/// Of the session's own data.
Section figures(const Content& content);
/// The images in contact; a section without blocks where there are none, or no thesis to set them beside.
Section contact_figures(const Content& content);
/// Each shot in numbers; those that do not count, with the reasons.
Section shots(const Content& content);
/// Each shot's photograph with what was found on it.
Section photographs(const Content& content);
/// What the uncertainties are made of.
Section budgets(const Content& content);
/// How the flashes came.
Section timing(const Content& content);
/// Versions and hashes of files.
Section records(const Content& content);
/// Where what ISO/IEC 17025 asks for stands, and what is not stated.
Section clauses(const Content& content, const std::vector<Section>& before);

}  // namespace strobe::lab_report
