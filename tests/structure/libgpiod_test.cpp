// libgpiod has one place in the product for each of its versions, which tests/sim/gpiochip/conformance runs on a real
// kernel.
#include <fmt/format.h>

#include <algorithm>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "tests/structure/source_tree.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe::structure;

const std::vector<std::string> kPlaces{"firmware/gpio/gpio_chip_v1.cpp", "firmware/gpio/gpio_chip_v2.cpp"};

bool is_place(const std::string& path) {
  return std::find(kPlaces.begin(), kPlaces.end(), path) != kPlaces.end();
}

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

TEST(Libgpiod, IsUsedInOneFileOfTheProductForEachVersion) {
  std::string elsewhere;
  for (const SourceFile& file : cpp_files()) {
    if (is_place(file.path) || top_folder(file.path) == "tests") continue;
    for (const Include& include : includes_of(file))
      if (starts_with(include.target, "gpiod"))
        elsewhere += fmt::format("\n  {}:{}: {}", file.path, include.line, include.target);
    for (const std::string& call : calls_in(file)) elsewhere += fmt::format("\n  {}: {}", file.path, call);
  }
  CHECK_EQUAL("", elsewhere);
  for (const std::string& place : kPlaces) CHECK_FALSE(calls_in(place).empty());
}
