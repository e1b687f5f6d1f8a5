// A report's HTML as PDF, by weasyprint. Starts it, reads and writes files; one thread.
#pragma once

#include <filesystem>
#include <string>

#include "common/result.hpp"

namespace strobe::report {

/// weasyprint, as $PATH has it. Fails with one line that says how to install it.
Result<std::filesystem::path> find_pdf_printer();

/// Prints `html` to `pdf`; dates within are those of `issued` ("2026-11-21": SOURCE_DATE_EPOCH), so that the
/// same report gives the same bytes. Fails with the program's last line.
Result<void> print_pdf(const std::filesystem::path& printer, const std::filesystem::path& html,
                       const std::filesystem::path& pdf, const std::string& issued);

}  // namespace strobe::report
