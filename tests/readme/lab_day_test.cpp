// A laboratory's whole day, typed in an empty folder, and its report read by somebody who has only the session's tables.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>
#include <vector>

#include "tests/support/json_lines.hpp"
#include "tests/support/process.hpp"
#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

using strobe::testing::ExitStatus;
namespace fs = std::filesystem;

namespace {

constexpr auto kLongestDay = std::chrono::seconds(900);
const std::vector<std::string> kSurfaces{"hard", "soft"};
const std::map<std::string, std::size_t> kShotsAskedFor{{"hard", 5}, {"soft", 4}};

/// Of the shots of a session that count, by the name of the column.
std::vector<double> column(const fs::path& session, const std::string& name) {
  const strobe::testing::CsvTable table = strobe::testing::read_csv(session / "results.csv");
  const std::size_t value = table.column(name), rejected = table.column("rejected");
  std::vector<double> values;
  for (const auto& row : table.rows)
    if (row.at(rejected).empty()) values.push_back(std::stod(row.at(value)));
  return values;
}

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

std::size_t count(const std::string& text, const std::string& word) {
  std::size_t found = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++found;
  return found;
}

/// The rows that give means of a table whose title begins so.
std::vector<nlohmann::json> means_of(const nlohmann::json& tables, const std::string& title) {
  std::vector<nlohmann::json> rows;
  for (const auto& [key, table] : tables.items()) {
    if (!table.at("title").get<std::string>().starts_with(title)) continue;
    for (const nlohmann::json& row : table.at("rows"))
      if (row.at("what").at("text").get<std::string>().starts_with("mean")) rows.push_back(row);
  }
  return rows;
}

void check_means(const nlohmann::json& results, const fs::path& folder) {
  const auto rows = means_of(results.at("tables"), "Parameters of the impact");
  CHECK_EQUAL(kSurfaces.size(), rows.size());
  for (const std::string& surface : kSurfaces) {
    const auto row = std::ranges::find_if(rows, [&](const nlohmann::json& each) {
      return each.at("condition").at("text").get<std::string>().ends_with("scene " + surface);
    });
    CHECK_TEXT(row != rows.end(), surface.c_str());
    for (const std::string name : {"e", "mu"}) {
      const std::vector<double> values = column(folder / surface, name);
      CHECK_EQUAL(kShotsAskedFor.at(surface), values.size());
      // Both sum the same few numbers of the order of one.
      DOUBLES_EQUAL(mean(values), row->at(name).at("number").get<double>(), 1e-12);
    }
  }
}

void check_photographs(const nlohmann::json& shots, const std::string& html) {
  std::size_t expected = 0;
  for (const auto& [surface, number] : kShotsAskedFor) {
    for (std::size_t shot = 1; shot <= number; ++shot) {
      const std::string name = fmt::format("{}:{}", surface, shot);
      CHECK_TEXT(shots.contains(name), name.c_str());
      CHECK_TEXT(shots.at(name).contains("picture"), name.c_str());
      CHECK_EQUAL_TEXT(1u, count(html, fmt::format("<img width=\"1100\" height=\"537\" alt=\"Shot {},", name)),
                       name.c_str());
    }
    expected += number;
  }
  CHECK_EQUAL(expected, shots.size());
  CHECK_EQUAL(expected, count(html, "src=\"data:image/jpeg;base64,/9j/"));
  CHECK_EQUAL(0u, count(html, "cannot be shown"));
}

}  // namespace

TEST_GROUP(LabDay){};

TEST(LabDay, EndsWithAReportThatLosesNoPhotographAndMixesNothing) {
  const strobe::testing::TemporaryFolder day;
  const std::string path = std::string(STROBE_BUILD_DIR) + "/bin:" + std::getenv("PATH");
  const auto typed = strobe::testing::run_process(
      {{std::string(STROBE_SOURCE_DIR) + "/tests/readme/lab_day.sh"}, {{"PATH", path}}, day.path(), {}}, kLongestDay);
  CHECK_TEXT(typed.status == ExitStatus({0, 0}), typed.err.c_str());

  STRCMP_CONTAINS("left out: board/slanted_9.tif: ", strobe::testing::read_text(day.path() / "calibrate.log").c_str());
  const std::string html = strobe::testing::read_text(day.path() / "report.html");
  const auto report = nlohmann::json::parse(strobe::testing::read_text(day.path() / "report.json")).at("sections");
  STRCMP_CONTAINS("9 of 9 shots counted, in 2 conditions",
                  report.at("identification").at("texts").at("in_short").get<std::string>().c_str());
  check_means(report.at("results"), day.path());
  check_photographs(report.at("photographs").at("shots"), html);
  STRCMP_CONTAINS("Corrected by hand", report.at("photographs").at("shots").at("hard:3").dump().c_str());
  const std::string pdf = strobe::testing::read_text(day.path() / "report.pdf");
  CHECK(pdf.starts_with("%PDF-"));
  CHECK_EQUAL(kShotsAskedFor.at("hard") + kShotsAskedFor.at("soft"), count(pdf, "/Subtype /Image"));
}
