#include "tests/support/json_lines.hpp"

#include <stdexcept>

#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe::testing;

TEST_GROUP(JsonLines) { TemporaryFolder folder; };

TEST(JsonLines, AreReadOneValueALine) {
  const auto values = parse_json_lines("{\"a\":1}\n\n{\"a\":2}");
  CHECK_EQUAL(2, values.size());
  CHECK_EQUAL(2, values[1]["a"].get<int>());
}

TEST(JsonLines, ThatAreBrokenAreNamed) {
  CHECK_THROWS(std::runtime_error, parse_json_lines("{\"a\":1}\n{\"a\":"));
}

TEST(JsonLines, OfAMissingFileAreNone) { CHECK(read_json_lines(folder / "none").empty()); }

TEST(JsonLines, TablesHaveNamedColumnsAndEmptyCells) {
  write_text(folder / "table.csv", "time_ns,line,name\n1,2,\n3,,KEY\n");
  const CsvTable table = read_csv(folder / "table.csv");
  CHECK_EQUAL(2, table.rows.size());
  CHECK_EQUAL("", table.rows[0].at(table.column("name")));
  CHECK_EQUAL("KEY", table.rows[1].at(table.column("name")));
  CHECK_THROWS(std::runtime_error, table.column("level"));
}
