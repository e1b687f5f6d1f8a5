// Who runs this program, and how, for others who use the same rig and for the session's record. Reads the system's
// tables; not thread-safe.
#pragma once

#include <string>
#include <vector>

namespace strobe::host {

/// "login@machine", at most 64 bytes, without blanks and control characters.
std::string operator_name();

/// As the program was started; none where the system does not tell.
std::vector<std::string> words_of_command_line();

}  // namespace strobe::host
