// strobe: the host's commands.
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <exception>
#include <new>

#include "host/commands/command.hpp"
#include "host/web/http/worker.hpp"

namespace {

/// What was printed may still be on its way to a full disk.
int finish_output(int exit_status) {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return exit_status;
  const int failed = strobe::host::failed("standard output: not everything could be written");
  return exit_status == strobe::host::kDone ? failed : exit_status;
}

/// What a viewer of the page asked for may still be computed, with what ending in order would take from under
/// it.
int end(int exit_status) {
  if (strobe::web::work_left_behind()) _exit(exit_status);
  return exit_status;
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is told like a full disk
  try {
    return end(finish_output(strobe::host::run_program(argc, argv)));
  } catch (const std::bad_alloc&) {
    return strobe::host::failed("there is not enough memory");
  } catch (const std::exception& error) {
    return strobe::host::failed(error.what());
  }
}
