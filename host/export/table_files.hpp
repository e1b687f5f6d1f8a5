// A folder of tables, TABLE.csv with its data dictionary, written as their rows come. A table appears under its name once
// all of it is on the disk. Writes files; one thread's.
#pragma once

#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "host/export/message_rows.hpp"

namespace strobe::host {

class TableFiles {
 public:
  explicit TableFiles(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// Appends to the row's table; the first row of a table decides its columns. What cannot be written is told by close().
  void add(const MessageRow& row);
  /// The last call. Fails with the path that cannot be written; tables that were there before still are, then.
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
