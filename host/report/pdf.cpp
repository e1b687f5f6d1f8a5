#include "host/report/pdf.hpp"

#include <fstream>
#include <iterator>

#include "common/config/files.hpp"
#include "host/config/camera_table.hpp"
#include "host/external/program.hpp"

namespace strobe::report {

namespace {

namespace fs = std::filesystem;

/// Seconds since 1970 of a day's begin; 0 for what is no day.
std::string epoch_of(const std::string& day) {
  const auto days = host::days_since(day, WallTime{});
  return std::to_string(days ? -*days * 86400 : 0);
}

}  // namespace

Result<fs::path> find_pdf_printer() {
  if (const auto found = external::find_program("weasyprint")) return *found;
  return fail("--pdf needs weasyprint, which is not in $PATH: apt-get install weasyprint");
}

Result<void> print_pdf(const fs::path& printer, const fs::path& html, const fs::path& pdf,
                       const std::string& issued) {
  const fs::path folder = pdf.has_parent_path() ? pdf.parent_path() : fs::path(".");
  const auto work = external::WorkFolder::make(folder);
  if (!work) return tl::unexpected(work.error());
  const fs::path& within = work->path();
  if (const auto done = external::run_program({printer, fs::absolute(html), within / "report.pdf"}, *work,
                                              {"SOURCE_DATE_EPOCH=" + epoch_of(issued)});
      !done)
    return fail("the report was not printed: " + done.error().message);
  // Larger than what read_file() is for.
  std::ifstream file(within / "report.pdf", std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(file), {}};
  if (bytes.rfind("%PDF-", 0) != 0 || bytes.size() < 1024 ||
      bytes.find("%%EOF", bytes.size() - 1024) == bytes.npos)
    return fail(printer.string() + " did not finish the PDF: " + work->last_message());
  return config::write_file(pdf, bytes);
}

}  // namespace strobe::report
