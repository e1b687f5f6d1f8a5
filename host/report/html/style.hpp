// The look of a report on paper and on a screen. Pure; thread-safe.
#pragma once

#include <string>
#include <string_view>

namespace strobe::lab_report {

/// A style sheet that numbers printed pages and names the report on each. `id`: letters, digits and - only.
std::string style_sheet(std::string_view id);

}  // namespace strobe::lab_report
