// How the digitizer's scores are reported: tables on standard output and lines of CSV. Not thread-safe.
#pragma once

#include <string>
#include <vector>

#include "host/digitize/digitize.hpp"
#include "tests/studies/digitize/photographs.hpp"
#include "tests/studies/digitize/score.hpp"

namespace strobe::studies::digitize {

double centre_rms_px(const Score& score);

void print_score_head(int name_width);
void print_score(const std::string& name, int name_width, const Score& score);

/// Columns of score_csv(), and one line of it without what names the row.
std::string score_csv_head();
std::string score_csv(const Score& score);

/// One line for each true image and each invented one.
std::string image_csv_head();
std::string image_csv(const std::string& name, int shot, const KnownPhotograph& known,
                      const strobe::digitize::Digitization& digitization);

/// Where the digitizer said that something could not be measured.
std::vector<ReportedPlace> reported_places(const strobe::digitize::Digitization& digitization);

}  // namespace strobe::studies::digitize
