// strobe export: an LCM log as tables or JSON lines, for other programs.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <system_error>

#include "common/authentication/key_file.hpp"
#include "host/commands/command.hpp"
#include "host/export/log_export.hpp"
#include "host/export/message_tables.hpp"

namespace strobe::host {
namespace {

namespace fs = std::filesystem;

struct ExportOptions {
  std::vector<std::string> logs;
  std::vector<std::string> kinds;
  std::string out;
  std::string table;
  std::string key_file;
  bool json = false;
};

Result<std::vector<fs::path>> all_logs(const std::vector<std::string>& given) {
  std::vector<fs::path> logs;
  for (const std::string& path : given) {
    const auto some = logs_of(path);
    if (!some) return tl::unexpected(some.error());
    logs.insert(logs.end(), some->begin(), some->end());
  }
  return logs;
}

/// Returns whether all of the log was given.
bool tell(const fs::path& log, const LogExportRemains& remains) {
  if (remains.damaged_bytes > 0)
    failed(fmt::format("{}: damaged: {} bytes are no record, the first at {}", log.string(),
                       remains.damaged_bytes, remains.first_damage));
  if (remains.undecodable > 0)
    failed(fmt::format("{}: {} packets are no message of this version", log.string(), remains.undecodable));
  return remains.damaged_bytes == 0 && remains.undecodable == 0;
}

/// give(log) gives its messages. 0: all of all logs; 2: there was none.
template <typename Give>
int for_each_log(const std::vector<fs::path>& logs, const Give& give) {
  bool whole = true;
  std::int64_t messages = 0;
  for (const fs::path& log : logs) {
    const Result<LogExportRemains> remains = give(log);
    if (!remains) return bad_input(remains.error().message);
    whole = tell(log, *remains) && whole;
    messages += remains->messages;
  }
  if (messages == 0) return bad_input(fmt::format("{}: no messages of these kinds", logs.front().string()));
  return whole ? kDone : kFailed;
}

int write_tables(const ExportOptions& options, const std::vector<fs::path>& logs,
                 const LogExportOptions& settings) {
  std::error_code error;
  fs::create_directories(options.out, error);
  if (error) return bad_input(options.out + ": " + error.message());
  TableFiles tables(options.out);
  const int status = for_each_log(logs, [&](const fs::path& log) {
    return export_rows(log, settings, [&](const MessageRow& row) { tables.add(row); });
  });
  if (status == kBadInput) return status;
  if (const auto closed = tables.close(); !closed) return failed(closed.error().message);
  for (const auto& [name, rows] : tables.rows())
    fmt::print("{}: {} rows\n", (fs::path(options.out) / (name + ".csv")).string(), rows);
  return status;
}

int print_table(const ExportOptions& options, const std::vector<fs::path>& logs,
                const LogExportOptions& settings) {
  bool first = true;
  const int status = for_each_log(logs, [&](const fs::path& log) {
    return export_rows(log, settings, [&](const MessageRow& row) {
      if (row.table != options.table) return;
      if (std::exchange(first, false)) std::fputs(csv_names(row).c_str(), stdout);
      std::fputs(csv_line(row).c_str(), stdout);
    });
  });
  if (status != kBadInput && first)
    return bad_input("export: --table " + options.table + ": no such table, or it has no rows");
  return status;
}

int run_export(const ExportOptions& options) {
  if (options.json + !options.table.empty() + !options.out.empty() != 1)
    return bad_input("export: give one of --out, --table and --json");
  const auto logs = all_logs(options.logs);
  if (!logs) return bad_input(logs.error().message);
  LogExportOptions settings;
  settings.kinds = {options.kinds.begin(), options.kinds.end()};
  if (!options.key_file.empty()) {
    const auto key = authentication::find_key({options.key_file, ""});
    if (!key) return bad_input(key.error().message);
    settings.key = key->key;
  }
  if (!options.out.empty()) return write_tables(options, *logs, settings);
  if (!options.table.empty()) return print_table(options, *logs, settings);
  return for_each_log(*logs, [&](const fs::path& log) {
    return export_json(log, settings, [](const std::string& line) { std::puts(line.c_str()); });
  });
}

}  // namespace

void add_export_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<ExportOptions>();
  CLI::App* command = app.add_subcommand("export", "Messages of a log as tables or JSON, for other programs");
  command
      ->add_option("LOG", options->logs,
                   "LCM logs, or session folders: their hosts' logs, else their journals")
      ->required();
  command
      ->add_option("--channel", options->kinds,
                   "only these: EVENT, STATUS, SHOT, FRAME, READOUT, COMMAND (default: all)")
      ->check(CLI::IsMember({"EVENT", "STATUS", "SHOT", "FRAME", "READOUT", "COMMAND"}));
  command->add_option("--out", options->out,
                      "folder for CSV tables and their data dictionaries, made if need be");
  command->add_option("--table", options->table, "print this table as CSV, e.g. event or shot.flashes");
  command->add_option("--key-file", options->key_file,
                      "check each packet's seal with this key: column `verified`");
  command->add_flag("--json", options->json,
                    "one JSON object per message on standard output, nothing else there");
  command->footer(
      "Examples: strobe export run1 --out run1/tables\n"
      "          strobe export run1 --channel SHOT --table shot.flashes > flashes.csv\n"
      "          strobe export run1/host-20260131T093000Z.lcmlog --channel READOUT --json\n"
      "Exit status: 1 if a part of a log is damaged or of another version; all else is given.");
  command->callback([options, &exit_status] { exit_status = run_export(*options); });
}

}  // namespace strobe::host
