// strobe-sim: the simulated rig as a program.
#include <csignal>

#include "sim/commands/commands.hpp"

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is told like a full disk
  return strobe::sim::run_program(argc, argv);
}
