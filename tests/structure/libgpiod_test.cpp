// libgpiod has one place in the product, so that another version's twin can stand beside it, and what is
// called there is what a real kernel is asked about.
#include <fmt/format.h>

#include <regex>
#include <set>
#include <string>

#include "tests/structure/source_tree.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe::structure;

const std::string kTheOnePlace = "firmware/linux/gpio_lines_v1.cpp";
const std::string kConformance = "tests/sim/gpiochip/conformance/library_calls.cpp";

std::set<std::string> calls_in(const SourceFile& file) {
  static const std::regex call("\\b(gpiod_\\w+)\\(");
  std::set<std::string> found;
  for (const std::string& line : file.lines) {
    if (line.find("gpiod_") == std::string::npos) continue;
    for (auto it = std::sregex_iterator(line.begin(), line.end(), call); it != std::sregex_iterator(); ++it)
      found.insert((*it)[1]);
  }
  return found;
}

std::set<std::string> calls_in(const std::string& path) {
  for (const SourceFile& file : cpp_files())
    if (file.path == path) return calls_in(file);
  return {};
}

}  // namespace

TEST_GROUP(Libgpiod){};

TEST(Libgpiod, IsUsedInOneFileOfTheProduct) {
  std::string elsewhere;
  for (const SourceFile& file : cpp_files()) {
    if (file.path == kTheOnePlace || top_folder(file.path) == "tests") continue;
    for (const Include& include : includes_of(file))
      if (starts_with(include.target, "gpiod"))
        elsewhere += fmt::format("\n  {}:{}: {}", file.path, include.line, include.target);
    for (const std::string& call : calls_in(file)) elsewhere += fmt::format("\n  {}: {}", file.path, call);
  }
  CHECK_EQUAL("", elsewhere);
  CHECK_FALSE(calls_in(kTheOnePlace).empty());
}

TEST(Libgpiod, IsAskedInTheConformanceProgramForEveryCallThatTheFirmwareMakes) {
  const std::set<std::string> asked = calls_in(kConformance);
  std::string missing;
  for (const std::string& call : calls_in(kTheOnePlace))
    if (asked.count(call) == 0) missing += "\n  " + call;
  CHECK_EQUAL("", missing);
}
