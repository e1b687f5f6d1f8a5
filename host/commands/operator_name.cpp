#include "host/commands/operator_name.hpp"

#include <pwd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>

namespace strobe::host {

std::string operator_name() {
  constexpr std::size_t kLongest = 64;
  const passwd* const entry = getpwuid(geteuid());
  const std::string login = entry && entry->pw_name ? entry->pw_name : std::to_string(geteuid());
  std::array<char, 256> machine{};
  if (gethostname(machine.data(), machine.size() - 1) != 0) machine = {'?'};
  std::string name = login + "@" + machine.data();
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return c <= ' ' || c == 0x7f; }, '_');
  return name.substr(0, kLongest);
}

std::vector<std::string> words_of_command_line() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  std::vector<std::string> words;
  for (std::string word; std::getline(file, word, '\0');) words.push_back(word);
  return words;
}

}  // namespace strobe::host
