#include "host/export/message_tables.hpp"

#include <unistd.h>
#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>
#include <system_error>
#include <utility>

#include "common/config/files.hpp"
#include "common/data/csv.hpp"
#include "host/session/record_file.hpp"

namespace strobe::host {

std::string unit_of_field(const std::string& name) {
  // Longer endings first.
  constexpr std::array<std::pair<std::string_view, std::string_view>, 14> kUnits{{
      {"_px_per_m", "{px}/m"},
      {"px_per_m", "{px}/m"},
      {"px_per_m_sd", "{px}/m"},
      {"_px2", "{px}2"},
      {"_px", "{px}"},
      {"_radps", "rad/s"},
      {"_rad", "rad"},
      {"_mps", "m/s"},
      {"_deg", "deg"},
      {"_ns", "ns"},
      {"_us", "us"},
      {"_ms", "ms"},
      {"_cm", "cm"},
      {"_m", "m"},
  }};
  for (const auto& [ending, unit] : kUnits) {
    if (name.ends_with(ending)) return std::string(unit);
  }
  return {};
}

bool is_identifier(std::string_view name) {
  return name.ends_with("boot_id") || name.ends_with("host_id") || name.ends_with("arm_token");
}

std::string identifier_text(std::string_view name, std::int64_t value) {
  return name.ends_with("boot_id") ? fmt::format("{:x}", static_cast<std::uint64_t>(value))
                                   : std::to_string(value);
}

namespace {

namespace fs = std::filesystem;

std::vector<Column> columns_of(const MessageRow& row) {
  std::vector<Column> columns;
  for (const MessageCell& cell : row.cells) {
    columns.push_back({cell.name, cell.datatype, unit_of_field(cell.name), cell.meaning});
  }
  return columns;
}

}  // namespace

std::string csv_line(const MessageRow& row) {
  std::string line;
  for (const MessageCell& cell : row.cells)
    line += (&cell == &row.cells.front() ? "" : ",") + data::csv_cell(cell.text);
  return line + "\n";
}

std::string csv_names(const MessageRow& row) { return csv_header(columns_of(row)) + "\n"; }

fs::path TableFiles::path_of(const std::string& table, const char* ending) const {
  return folder_ / (table + ending);
}

TableFiles::Table& TableFiles::table_of(const MessageRow& row) {
  const auto [entry, is_new] = tables_.try_emplace(row.table);
  Table& table = entry->second;
  if (!is_new) return table;
  table.columns = columns_of(row);
  const fs::path path = path_of(row.table, ".csv.part");
  table.file.reset(std::fopen(path.c_str(), "wb"));
  if (!table.file) {
    if (problem_.empty()) problem_ = path.string() + ": " + std::strerror(errno);
    return table;
  }
  std::fputs(csv_names(row).c_str(), table.file.get());
  return table;
}

void TableFiles::add(const MessageRow& row) {
  Table& table = table_of(row);
  ++rows_[row.table];
  const std::string line = csv_line(row);
  if (table.file) std::fwrite(line.data(), 1, line.size(), table.file.get());
}

Result<void> TableFiles::finish(const std::string& name, Table& table) {
  const fs::path part = path_of(name, ".csv.part"), path = path_of(name, ".csv");
  const bool written = std::ferror(table.file.get()) == 0 && std::fflush(table.file.get()) == 0 &&
                       ::fsync(::fileno(table.file.get())) == 0;
  if (!written) return fail(part.string() + ": " + std::strerror(errno != 0 ? errno : EIO));
  table.file.reset();
  if (::rename(part.c_str(), path.c_str()) != 0) return fail(path.string() + ": " + std::strerror(errno));
  return config::write_file(path.string() + "-metadata.json",
                            data_dictionary(name + ".csv", "Messages of an LCM log: " + name, table.columns));
}

Result<void> TableFiles::close() {
  if (!problem_.empty()) return fail(problem_);
  for (auto& [name, table] : tables_) {
    if (auto finished = finish(name, table); !finished) return finished;
  }
  if (!config::sync_folder(folder_)) return fail(folder_.string() + ": " + std::strerror(errno));
  return {};
}

}  // namespace strobe::host
