#include "tests/support/recorded.hpp"

#include <cmath>
#include <cstdlib>
#include <sstream>

#include "tests/support/temporary_folder.hpp"

namespace strobe::testing {

bool alike(const std::string& line, const std::string& other, double tolerance) {
  std::istringstream words(line), others(other);
  for (std::string a, b;;) {
    words >> a;
    others >> b;
    if (!words || !others) return !words && !others;
    char *a_end = nullptr, *b_end = nullptr;
    const double x = std::strtod(a.c_str(), &a_end), y = std::strtod(b.c_str(), &b_end);
    const bool numbers = *a_end == '\0' && *b_end == '\0';
    if (a != b && !(numbers && std::abs(x - y) <= tolerance)) return false;
  }
}

std::string difference_from_record(const std::string& name, const std::string& text, double tolerance) {
  const std::string path = std::string(STROBE_TEST_DATA "/recorded") + "/" + name + ".txt";
  if (std::getenv("STROBE_RECORD") != nullptr) write_text(path, text);
  std::istringstream before(read_text(path)), now(text);
  std::string heading;
  for (std::string line, other;;) {
    std::getline(before, line);
    std::getline(now, other);
    if (!before && !now) return "";
    if (!before || !now || !alike(line, other, tolerance)) return heading + "\n- " + line + "\n+ " + other;
    if (line.starts_with('#')) heading = line;
  }
}

}  // namespace strobe::testing
