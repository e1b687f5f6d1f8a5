// An LCM message as rows of tables: one row of its own with the fields of the messages in it
// ("plan.period_ns"), and for each of its lists a table with one row an element ("shot.flashes"). Absent
// numbers and instants are empty. Ids of boots are hexadecimal, as in results.csv. Pure; thread-safe;
// allocates.
#pragma once

#include <fmt/format.h>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <message_fields.hpp>
#include <string>
#include <type_traits>
#include <vector>

#include "common/result.hpp"
#include "host/session/shot_table.hpp"

namespace strobe::host {

struct MessageCell {
  std::string name;
  std::string text;  ///< not quoted
  const char* datatype = "string";
  const char* meaning = "";
};

struct MessageRow {
  std::string table;
  std::vector<MessageCell> cells;
};

using TakeRow = std::function<void(const MessageRow&)>;

/// A column's unit by its name's ending, UCUM; empty: none.
std::string unit_of_field(const std::string& name);

/// An identifier: any 64 bits, so that no program may read it as a rounded number.
bool is_identifier(std::string_view name);

/// "1f2e" of a boot's, "-5" of others.
std::string identifier_text(std::string_view name, std::int64_t value);

/// The instant that is none, in every type that has one.
inline constexpr std::int64_t kNoTime_ns = INT64_MIN;

class RowVisitor {
 public:
  /// keys: the first cells of the row and of those of its lists.
  RowVisitor(std::string table, std::vector<MessageCell> keys, const TakeRow& take)
      : keys_(keys), row_{std::move(table), std::move(keys)}, take_(take) {}

  void field(const char* name, bool value, const char* meaning) {
    add(name, value ? "true" : "false", "boolean", meaning);
  }
  void field(const char* name, double value, const char* meaning) {
    add(name, std::isnan(value) ? std::string() : fmt::format("{}", value), "number", meaning);
  }
  void field(const char* name, const std::string& value, const char* meaning) {
    add(name, value, "string", meaning);
  }
  template <typename Integer>
  requires std::is_integral_v<Integer>
  void field(const char* name, Integer value, const char* meaning) {
    const auto wide = static_cast<std::int64_t>(value);
    if (is_identifier(name))
      add(name, identifier_text(name, wide), "string", meaning);
    else
      add(name, wide == kNoTime_ns ? std::string() : std::to_string(wide), "integer", meaning);
  }

  template <typename Message>
  void part(const char* name, const Message& message) {
    const std::string outer = prefix_;
    prefix_ += std::string(name) + ".";
    messages::visit_fields(message, *this);
    prefix_ = outer;
  }

  template <typename Element>
  void list(const char* name, const std::vector<Element>& elements) {
    const std::string path = prefix_ + name;
    std::vector<MessageCell> keys = keys_;
    keys.push_back({path + "_index", "", "integer", "place in the list, from 0"});
    for (std::size_t i = 0; i < elements.size(); ++i) {
      keys.back().text = std::to_string(i);
      RowVisitor row(row_.table + "." + path, keys, take_);
      if constexpr (std::is_class_v<Element> && !std::is_same_v<Element, std::string>)
        messages::visit_fields(elements[i], row);
      else
        row.field("value", elements[i], "");
      row.end();
    }
  }

  /// A cell that is not the message's.
  void add(MessageCell cell) { row_.cells.push_back(std::move(cell)); }
  /// Hands the row over.
  void end() const { take_(row_); }

 private:
  void add(const char* name, std::string text, const char* datatype, const char* meaning) {
    row_.cells.push_back({prefix_ + name, std::move(text), datatype, meaning});
  }

  std::vector<MessageCell> keys_;
  MessageRow row_;
  const TakeRow& take_;
  std::string prefix_;
};

// A folder of tables, TABLE.csv with its data dictionary, written as their rows come. A table appears under
// its name once all of it is on the disk. Writes files; one thread's.

class TableFiles {
 public:
  explicit TableFiles(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// Appends to the row's table; the first row of a table decides its columns. What cannot be written is told
  /// by close().
  void add(const MessageRow& row);
  /// The last call. Fails with the path that cannot be written; tables that were there before still are,
  /// then.
  Result<void> close();
  /// Of close(): rows by table.
  const std::map<std::string, std::int64_t>& rows() const { return rows_; }

 private:
  struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  struct Table {
    std::unique_ptr<std::FILE, CloseFile> file;
    std::vector<Column> columns;
  };
  Table& table_of(const MessageRow& row);
  std::filesystem::path path_of(const std::string& table, const char* ending) const;
  Result<void> finish(const std::string& name, Table& table);

  std::filesystem::path folder_;
  std::map<std::string, Table> tables_;
  std::map<std::string, std::int64_t> rows_;
  std::string problem_;
};

/// "a,b\n"; cells quoted where need be.
std::string csv_line(const MessageRow& row);
std::string csv_names(const MessageRow& row);

}  // namespace strobe::host
