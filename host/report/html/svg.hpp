// Draws a chart as SVG to stand within HTML: no script, no style of its own, nothing loaded. The same chart gives the same
// bytes. Pure; thread-safe; allocates.
#pragma once

#include <string>

#include "host/report/charts/chart.hpp"

namespace strobe::lab_report {

std::string svg_of(const Chart& chart);

}  // namespace strobe::lab_report
