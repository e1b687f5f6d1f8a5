#include "host/commands/command.hpp"

#include <cstdio>

namespace strobe::host {
namespace {

void print_line(std::string what) {
  for (char& c : what) {
    if (c == '\n' || c == '\r') c = ' ';
  }
  std::fprintf(stderr, "strobe: %s\n", what.c_str());
}

}  // namespace

int bad_input(const std::string& what) {
  print_line(what);
  return kBadInput;
}

int failed(const std::string& what) {
  print_line(what);
  return kFailed;
}

}  // namespace strobe::host
