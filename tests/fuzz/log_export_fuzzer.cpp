// A log is somebody's file: any bytes give rows that fit their table's columns, JSON that parses, and a true account of
// what was damaged; both ways of export give the same messages.
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "host/export/log_export.hpp"
#include "tests/fuzz/require.hpp"

using namespace strobe::fuzz;
using namespace strobe::host;

namespace {

/// In memory, of this process alone.
std::filesystem::path file() {
  const std::filesystem::path path = "/dev/shm/strobe-fuzz-export-" + std::to_string(getpid());
  std::filesystem::create_directories(path);
  return path / "host.lcmlog";
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::filesystem::path path = file();
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  std::map<std::string, std::size_t> columns;
  const auto rows = export_rows(path, {}, [&](const MessageRow& row) {
    require(columns.try_emplace(row.table, row.cells.size()).first->second == row.cells.size());
  });
  std::int64_t lines = 0;
  const auto json = export_json(path, {}, [&](const std::string& line) {
    ++lines;
    require(!nlohmann::json::parse(line, nullptr, false).is_discarded());
  });
  require(rows.has_value() && json.has_value() && rows->messages == json->messages &&
          json->messages == lines);
  require(rows->damaged_bytes >= 0 && rows->damaged_bytes <= static_cast<std::int64_t>(size));
  require((rows->damaged_bytes > 0) == (rows->first_damage >= 0));
  return 0;
}
