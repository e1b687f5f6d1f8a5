// A report's HTML as PDF, by a program of Debian's. Starts it, reads and writes files; one thread.
#pragma once

#include <filesystem>
#include <string>

#include "common/result.hpp"

namespace strobe::lab_report {

/// weasyprint, chromium or wkhtmltopdf: the first that $PATH has. Fails with one line that says which were looked for.
Result<std::filesystem::path> find_pdf_printer();

/// Prints `html` to `pdf`; dates within are those of `issued` ("2026-11-21"), so that the same report gives the same bytes
/// as far as the program allows. Fails with the program's last line.
Result<void> print_pdf(const std::filesystem::path& printer, const std::filesystem::path& html,
                       const std::filesystem::path& pdf, const std::string& issued);

}  // namespace strobe::lab_report
