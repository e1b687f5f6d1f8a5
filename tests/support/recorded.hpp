// Numbers on record: what a program computed when it was last judged right. They notice what other tests' tolerances
// let pass. With STROBE_RECORD set the record is written anew: after a change that is meant, to be looked at as a diff.
#pragma once

#include <string>

namespace strobe::testing {

/// Whether two lines have the same words, and numbers that differ by at most the tolerance.
bool alike(const std::string& line, const std::string& other, double tolerance);

/// The first line of `text` that is not like that of tests/data/recorded/NAME.txt, after the last line before it that
/// begins with '#'. Empty if there is none.
std::string difference_from_record(const std::string& name, const std::string& text, double tolerance);

}  // namespace strobe::testing
