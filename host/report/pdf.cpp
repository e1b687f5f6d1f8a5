#include "host/report/pdf.hpp"

#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstring>
#include <vector>

#include "common/config/files.hpp"
#include "host/config/camera_table.hpp"
#include "host/external/program.hpp"

namespace strobe::lab_report {

namespace {

namespace fs = std::filesystem;

constexpr std::array<const char*, 3> kPrinters{"weasyprint", "chromium", "wkhtmltopdf"};

std::vector<std::string> arguments(const fs::path& printer, const fs::path& html, const fs::path& work) {
  const std::string program = printer.filename().string(), out = (work / "report.pdf").string();
  if (program == "chromium") {
    std::vector<std::string> words{printer.string(),
                                   "--headless",
                                   "--disable-gpu",
                                   "--no-pdf-header-footer",
                                   "--user-data-dir=" + (work / "profile").string(),
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
    if (const auto found = external::find_program(program)) return *found;
  return fail(
      "--pdf needs weasyprint, chromium or wkhtmltopdf, none of which is in $PATH: apt-get install "
      "weasyprint");
}

Result<void> print_pdf(const fs::path& printer, const fs::path& html, const fs::path& pdf,
                       const std::string& issued) {
  const fs::path folder = pdf.has_parent_path() ? pdf.parent_path() : fs::path(".");
  const auto work = external::WorkFolder::make(folder);
  if (!work) return tl::unexpected(work.error());
  const fs::path& within = work->path();
  if (const auto done = external::run_program(arguments(printer, fs::absolute(html), within), *work,
                                              {"SOURCE_DATE_EPOCH=" + epoch_of(issued)});
      !done)
    return fail("the report was not printed: " + done.error().message);
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
    return fail(printer.string() + " did not finish the PDF: " + work->last_message());
  set_dates(bytes, issued);
  return config::write_file(pdf, bytes);
}

}  // namespace strobe::lab_report
