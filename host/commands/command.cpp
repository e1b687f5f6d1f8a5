#include "host/commands/command.hpp"

#include <pwd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>

namespace strobe::host {
namespace {

void print_line(std::string what) {
  for (char& c : what) {
    if (c == '\n' || c == '\r') c = ' ';
  }
  std::fprintf(stderr, "strobe: %s\n", what.c_str());
}

}  // namespace

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

std::vector<std::string> typed_command_line() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  std::vector<std::string> words;
  for (std::string word; std::getline(file, word, '\0');) words.push_back(word);
  return words;
}

int bad_input(const std::string& what) {
  print_line(what);
  return kBadInput;
}

int failed(const std::string& what) {
  print_line(what);
  return kFailed;
}

}  // namespace strobe::host
