#include "tests/benchmarks/timing/load.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <thread>

namespace strobe::benchmarks::timing {

namespace {

constexpr std::size_t kBytes = std::size_t{64} << 20;
constexpr std::size_t kBlock = std::size_t{1} << 20;

// Each runs for ever in a forked child: system calls and plain arithmetic only.
[[noreturn]] void compute() {
  volatile std::uint64_t state = 1;
  for (;;) state = state * 6364136223846793005ULL + 1442695040888963407ULL;
}

char* pages(std::size_t bytes) {
  void* memory =
      mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_POPULATE, -1, 0);
  if (memory == MAP_FAILED) _exit(1);
  return static_cast<char*>(memory);
}

[[noreturn]] void copy_memory() {
  char* memory = pages(2 * kBytes);
  for (unsigned char round = 0;; ++round) {
    memory[round] = static_cast<char>(round);
    std::memcpy(memory + kBytes, memory, kBytes);
    std::memcpy(memory, memory + kBytes, kBytes);
  }
}

[[noreturn]] void write_disk(const char* path) {
  const char* block = pages(kBlock);
  const int file = open(path, O_CREAT | O_WRONLY | O_TRUNC | O_CLOEXEC, 0600);
  for (;;) {
    for (std::size_t done = 0; done < kBytes; done += kBlock)
      if (write(file, block, kBlock) < 0) _exit(1);
    if (fdatasync(file) != 0 || lseek(file, 0, SEEK_SET) != 0) _exit(1);
  }
}

}  // namespace

template <typename Work>
void Load::start(Work work) {
  const pid_t child = fork();
  if (child == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    work();
  }
  if (child > 0) processes_.push_back(child);
}

Load::Load(const std::string& kind, const std::filesystem::path& folder) : file_(folder / "load.bin") {
  const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
  for (unsigned core = 0; core < cores; ++core) {
    if (kind == "cpu") start(compute);
    if (kind == "memory") start(copy_memory);
  }
  const std::string path = file_;
  if (kind == "memory") start([&path] { write_disk(path.c_str()); });
}

Load::~Load() {
  for (const pid_t process : processes_) kill(process, SIGKILL);
  for (const pid_t process : processes_) waitpid(process, nullptr, 0);
  std::error_code ignored;
  std::filesystem::remove(file_, ignored);
}

}  // namespace strobe::benchmarks::timing
