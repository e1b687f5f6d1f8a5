// A report as data: sections of facts, tables, charts, shots and texts, in the order in which a person reads
// them. HTML and JSON are two ways of writing it, so that neither shows what the other lacks. Plain values;
// thread-safe.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "host/figures/figure.hpp"

namespace strobe::report {

using figures::Chart;

/// A word with its value. Texts are shown as they are, whatever markup they hold.
struct Fact {
  std::string key;  ///< in JSON
  std::string label;
  std::string text;                ///< as shown
  std::optional<double> number{};  ///< the same at full precision
  bool stated = true;              ///< false: nobody said it; `text` says so
};

struct Facts {
  std::string key;
  std::string title;  ///< may be empty
  std::vector<Fact> facts;
};

struct Cell {
  std::string text;  ///< as shown
  std::optional<double> number;

  Cell(std::string its_text, std::optional<double> its_number = {})
      : text(std::move(its_text)), number(its_number) {}
  Cell(std::string_view its_text) : text(its_text) {}
  Cell(const char* its_text) : text(its_text) {}
};

struct Column {
  std::string key;  ///< in JSON, with its unit
  std::string head;
  std::string unit;
  bool is_number = true;  ///< false: words, aligned to the left
};

struct Row {
  std::vector<Cell> cells;  ///< one for each column
  bool begins = false;      ///< a group of rows that belong together
  bool beside = false;      ///< for comparison: not this report's own result
};

struct Table {
  std::string key;
  std::string title;
  std::vector<Column> columns;
  std::vector<Row> rows{};
  std::vector<std::string> notes{};
};

struct Paragraph {
  std::string key;
  std::string text;
  bool is_emphasized = false;
  bool leads = false;  ///< to what comes next, on the same page
};

/// Lines of a file.
struct Listing {
  std::string key;
  std::string title;
  std::string text;
};

struct Picture {
  std::vector<std::uint8_t> jpeg;
  int width_px = 0, height_px = 0;
};

/// One shot with what was found on its photograph.
struct ShotCard {
  std::string key;
  std::string title;
  bool counts = true;
  std::optional<Picture> picture;
  std::string no_picture;  ///< why there is none
  std::vector<Fact> facts;
  std::string drawing{};  ///< an SVG of what the facts say of the spin's axis; may be empty
  std::vector<std::string> remarks;
};

/// Places to sign.
struct Signature {
  std::string key;
  std::vector<Fact> lines;  ///< what stands beneath each
};

using Block = std::variant<Facts, Table, Chart, Paragraph, Listing, ShotCard, Signature>;

struct Section {
  std::string key;
  std::string title;
  std::vector<Block> blocks{};
};

struct Report {
  std::string id;  ///< by its content, see identify()
  std::string title;
  std::string issued;  ///< a day
  std::vector<Section> sections;
};

}  // namespace strobe::report
