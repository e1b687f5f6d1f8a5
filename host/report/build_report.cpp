#include "host/report/build_report.hpp"

#include "host/report/content/content.hpp"
#include "host/report/model/report_json.hpp"
#include "host/report/sections/sections.hpp"

namespace strobe::lab_report {

Report build_report(const ReportInput& input) {
  const Content content = content_of(input);
  Report report;
  report.title = content.stated("title");
  if (report.title.empty()) report.title = "Report on the impact of a ball on a surface";
  report.issued = content.stated("issued");
  if (report.issued.empty()) report.issued = content.last_day;
  report.sections.push_back(identification(content, report.issued));
  report.sections.push_back(conformity(content));
  report.sections.push_back(results(content));
  report.sections.push_back(method(content));
  report.sections.push_back(set_up(content));
  report.sections.push_back(commissioning(content));
  report.sections.push_back(figures(content));
  if (Section contact = contact_figures(content); !contact.blocks.empty())
    report.sections.push_back(std::move(contact));
  report.sections.push_back(shots(content));
  report.sections.push_back(photographs(content));
  report.sections.push_back(budgets(content));
  report.sections.push_back(timing(content));
  report.sections.push_back(records(content));
  report.sections.push_back(clauses(content, report.sections));
  report.id = identify(report);
  return report;
}

}  // namespace strobe::lab_report
