#include "host/report/pdf.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <sstream>
#include <utility>
#include <vector>

#include "common/config/files.hpp"
#include "host/config/camera_table.hpp"

namespace strobe::lab_report {

namespace {

namespace fs = std::filesystem;

constexpr std::array<const char*, 3> kPrinters{"weasyprint", "chromium", "wkhtmltopdf"};

std::optional<fs::path> in_path(const char* program) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const fs::path candidate = fs::path(folder.empty() ? "." : folder) / program;
    if (access(candidate.c_str(), X_OK) == 0) return fs::absolute(candidate);
  }
  return std::nullopt;
}

/// A folder that goes when the object does, with all that is in it.
class Workshop {
 public:
  static Result<Workshop> make(const fs::path& folder) {
    std::string name = (folder / ".printing-XXXXXX").string();
    if (!mkdtemp(name.data())) return fail(folder.string() + ": cannot be written: " + std::strerror(errno));
    return Workshop(name);
  }
  Workshop(Workshop&& other) noexcept : path_(std::exchange(other.path_, {})) {}
  Workshop& operator=(Workshop&&) = delete;
  ~Workshop() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
  }
  const fs::path& path() const { return path_; }

 private:
  explicit Workshop(fs::path path) : path_(std::move(path)) {}
  fs::path path_;
};

std::vector<std::string> arguments(const fs::path& printer, const fs::path& html, const fs::path& workshop) {
  const std::string program = printer.filename().string(), out = (workshop / "report.pdf").string();
  if (program == "chromium") {
    std::vector<std::string> words{printer.string(),
                                   "--headless",
                                   "--disable-gpu",
                                   "--no-pdf-header-footer",
                                   "--user-data-dir=" + (workshop / "profile").string(),
                                   "--print-to-pdf=" + out};
    if (geteuid() == 0) words.push_back("--no-sandbox");  // which it asks of root
    words.push_back("file://" + html.string());
    return words;
  }
  if (program == "wkhtmltopdf")
    return {printer.string(),
            "--quiet",
            "--disable-javascript",
            "--footer-font-size",
            "8",
            "--footer-left",
            "[title]",
            "--footer-right",
            "page [page] of [topage]",
            html.string(),
            out};
  return {printer.string(), html.string(), out};
}

/// Seconds since 1970 of a day's begin; 0 for what is no day.
std::string epoch_of(const std::string& day) {
  const auto days = host::days_since(day, WallTime{});
  return std::to_string(days ? -*days * 86400 : 0);
}

std::string last_line(const fs::path& log) {
  const auto text = config::read_file(log.string());
  std::istringstream lines(text ? *text : "");
  std::string last = "no message";
  for (std::string line; std::getline(lines, line);)
    if (line.find_first_not_of(" \t\r") != line.npos) last = line;
  return last;
}

Result<void> run(std::vector<std::string> words, const fs::path& workshop, const std::string& issued) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  const std::string log = (workshop / "log").string();
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  std::vector<char*> environment;
  std::string epoch = "SOURCE_DATE_EPOCH=" + epoch_of(issued);
  environment.push_back(epoch.data());
  for (char** entry = environ; *entry != nullptr; ++entry)
    if (std::string_view(*entry).rfind("SOURCE_DATE_EPOCH=", 0) != 0) environment.push_back(*entry);
  environment.push_back(nullptr);
  pid_t pid = 0;
  const int error = posix_spawn(&pid, pointers[0], &actions, nullptr, pointers.data(), environment.data());
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) return fail(words[0] + ": cannot be started: " + std::strerror(error));
  int status = 0;
  while (waitpid(pid, &status, 0) < 0)
    if (errno != EINTR) return fail(words[0] + ": lost: " + std::strerror(errno));
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    return fail(words[0] + " did not print the report: " + last_line(log));
  return {};
}

/// Dates that the program wrote are replaced by the issue's, digit by digit: what follows stays where it is.
void set_dates(std::string& pdf, const std::string& issued) {
  std::string digits;
  for (const char c : issued)
    if (c >= '0' && c <= '9') digits += c;
  if (digits.size() != 8) return;
  digits += "000000";
  for (const char* key : {"/CreationDate (D:", "/ModDate (D:"}) {
    for (std::size_t at = pdf.find(key); at != pdf.npos; at = pdf.find(key, at + 1)) {
      const std::size_t from = at + std::strlen(key);
      for (std::size_t i = 0;
           i < digits.size() && from + i < pdf.size() && pdf[from + i] >= '0' && pdf[from + i] <= '9'; ++i)
        pdf[from + i] = digits[i];
    }
  }
}

}  // namespace

Result<fs::path> find_pdf_printer() {
  for (const char* program : kPrinters)
    if (const auto found = in_path(program)) return *found;
  return fail(
      "--pdf needs weasyprint, chromium or wkhtmltopdf, none of which is in $PATH: apt-get install "
      "weasyprint");
}

Result<void> print_pdf(const fs::path& printer, const fs::path& html, const fs::path& pdf,
                       const std::string& issued) {
  const fs::path folder = pdf.has_parent_path() ? pdf.parent_path() : fs::path(".");
  const auto workshop = Workshop::make(folder);
  if (!workshop) return tl::unexpected(workshop.error());
  const fs::path within = fs::absolute(workshop->path());
  if (const auto done = run(arguments(printer, fs::absolute(html), within), within, issued); !done)
    return done;
  // Larger than what read_file() is for.
  std::string bytes;
  if (std::FILE* file = std::fopen((within / "report.pdf").c_str(), "rb")) {
    std::array<char, 65536> piece{};
    for (std::size_t n = 0; (n = std::fread(piece.data(), 1, piece.size(), file)) > 0;)
      bytes.append(piece.data(), n);
    std::fclose(file);
  }
  if (bytes.rfind("%PDF-", 0) != 0 || bytes.size() < 1024 ||
      bytes.find("%%EOF", bytes.size() - 1024) == bytes.npos)
    return fail(printer.string() + " did not finish the PDF: " + last_line(within / "log"));
  set_dates(bytes, issued);
  return config::write_file(pdf, bytes);
}

}  // namespace strobe::lab_report
