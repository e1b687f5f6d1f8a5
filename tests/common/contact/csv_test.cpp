#include "common/data/csv.hpp"

#include <string>
#include <vector>

#include "tests/support/string_from.hpp"

using namespace strobe::data;

TEST_GROUP(Csv){};

TEST(Csv, ReadsCellsInQuotesAsTheyWereWritten) {
  for (const std::string text :
       {"", "plain", " a ", "a,b", "\"", "say \"no\"", "two\nlines", "cr\r", ",\",\n\""}) {
    const std::vector<std::string> cells = csv_cells("1," + csv_cell(text) + ",2");
    LONGS_EQUAL(3, cells.size());
    CHECK_EQUAL(text, cells[1]);
  }
  CHECK_EQUAL("plain", csv_cell("plain"));
  CHECK_EQUAL("\"a,b\"", csv_cell("a,b"));
}

TEST(Csv, TellsTheLineOnWhichARowBegins) {
  const auto rows = csv_rows("\xEF\xBB\xBFname,note\r\n\r\n1,\"two\nlines\"\r\n2,x");
  LONGS_EQUAL(3, rows.size());
  CHECK_EQUAL("name", rows[0].cells[0]);
  CHECK_EQUAL("two\nlines", rows[1].cells[1]);
  LONGS_EQUAL(3, rows[1].line);
  LONGS_EQUAL(5, rows[2].line);
  CHECK_EQUAL("x", rows[2].cells[1]);
}

TEST(Csv, HasACellBetweenAndBesideCommas) {
  LONGS_EQUAL(1, csv_cells("").size());
  LONGS_EQUAL(3, csv_cells(",,").size());
  CHECK(csv_rows("\n\n").empty());
  CHECK_EQUAL("the end", csv_cells("a,\"the end")[1]);
}
