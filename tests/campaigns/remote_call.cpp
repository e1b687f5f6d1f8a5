#include "tests/campaigns/remote_call.hpp"

#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <sys/user.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <string>

namespace strobe::ends {

std::vector<pid_t> threads_of(pid_t pid) {
  std::vector<pid_t> threads;
  std::error_code gone;
  for (const auto& entry :
       std::filesystem::directory_iterator("/proc/" + std::to_string(pid) + "/task", gone))
    threads.push_back(std::stoi(entry.path().filename().string()));
  std::sort(threads.begin(), threads.end());
  return threads;
}

#if defined(__x86_64__)

namespace {

/// Of a thread that stopped; false if it ended instead.
bool wait_stopped(pid_t thread) {
  int status = 0;
  return waitpid(thread, &status, __WALL) == thread && WIFSTOPPED(status);
}

/// Where the kernel's own page (vdso(7)) has a `syscall` instruction; 0: nowhere.
std::uint64_t syscall_instruction(pid_t thread) {
  std::ifstream maps("/proc/" + std::to_string(thread) + "/maps");
  for (std::string line; std::getline(maps, line);) {
    if (line.find("[vdso]") == std::string::npos) continue;
    const std::uint64_t begin = std::stoull(line, nullptr, 16);
    const std::uint64_t end = std::stoull(line.substr(line.find('-') + 1), nullptr, 16);
    std::vector<unsigned char> text(end - begin);
    iovec here{text.data(), text.size()};
    iovec there{reinterpret_cast<void*>(begin), text.size()};
    if (process_vm_readv(thread, &here, 1, &there, 1, 0) != static_cast<ssize_t>(text.size())) return 0;
    constexpr std::array<unsigned char, 2> kSyscall{0x0f, 0x05};
    const auto found = std::search(text.begin(), text.end(), kSyscall.begin(), kSyscall.end());
    return found == text.end() ? 0 : begin + static_cast<std::uint64_t>(found - text.begin());
  }
  return 0;
}

bool prepare(pid_t thread, std::int64_t number, const std::array<std::int64_t, 6>& arguments,
             user_regs_struct& before) {
  const std::uint64_t instruction = syscall_instruction(thread);
  if (instruction == 0 || ptrace(PTRACE_GETREGS, thread, nullptr, &before) != 0) return false;
  user_regs_struct call = before;
  const auto word = [](std::int64_t value) { return static_cast<unsigned long long>(value); };
  call.rip = instruction;
  call.rax = word(number);
  call.orig_rax = word(-1);  // no call that was interrupted is begun again before this one
  call.rdi = word(arguments[0]);
  call.rsi = word(arguments[1]);
  call.rdx = word(arguments[2]);
  call.r10 = word(arguments[3]);
  call.r8 = word(arguments[4]);
  call.r9 = word(arguments[5]);
  return ptrace(PTRACE_SETREGS, thread, nullptr, &call) == 0;
}

}  // namespace

HeldThread::HeldThread(pid_t thread) : thread_(thread) {
  if (ptrace(PTRACE_SEIZE, thread, nullptr, nullptr) != 0) return;
  held_ = ptrace(PTRACE_INTERRUPT, thread, nullptr, nullptr) == 0 && wait_stopped(thread);
}

HeldThread::~HeldThread() {
  if (held_) ptrace(PTRACE_DETACH, thread_, nullptr, nullptr);
}

std::optional<std::int64_t> HeldThread::call(std::int64_t number,
                                             const std::array<std::int64_t, 6>& arguments) {
  user_regs_struct before{};
  if (!held_ || !prepare(thread_, number, arguments, before)) return std::nullopt;
  held_ = ptrace(PTRACE_SINGLESTEP, thread_, nullptr, nullptr) == 0 && wait_stopped(thread_);
  user_regs_struct after{};
  if (!held_ || ptrace(PTRACE_GETREGS, thread_, nullptr, &after) != 0) return std::nullopt;
  ptrace(PTRACE_SETREGS, thread_, nullptr, &before);
  return static_cast<std::int64_t>(after.rax);
}

void HeldThread::end() {
  user_regs_struct before{};
  if (!held_ || !prepare(thread_, SYS_exit, {}, before)) return;
  ptrace(PTRACE_DETACH, thread_, nullptr, nullptr);
  held_ = false;
}

bool fail_system_call(HeldThread& thread, pid_t pid, int number, int error) {
  constexpr std::int64_t kPage = 4096;
  const auto page =
      thread.call(SYS_mmap, {0, kPage, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0});
  if (!page || *page < 0) return false;
  const auto field = static_cast<std::uint32_t>(offsetof(seccomp_data, nr));
  const std::array<sock_filter, 4> filter{{
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, field),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(number), 0, 1),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | static_cast<std::uint32_t>(error)),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
  }};
  struct {
    sock_fprog program;
    std::array<sock_filter, 4> filter;
  } there{};
  there.program.len = filter.size();
  there.program.filter =
      reinterpret_cast<sock_filter*>(*page + static_cast<std::int64_t>(sizeof(sock_fprog)));
  there.filter = filter;
  iovec from{&there, sizeof there};
  iovec to{reinterpret_cast<void*>(*page), sizeof there};
  if (process_vm_writev(pid, &from, 1, &to, 1, 0) != static_cast<ssize_t>(sizeof there)) return false;
  if (thread.call(SYS_prctl, {PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0, 0}) != 0) return false;
  return thread.call(SYS_seccomp, {SECCOMP_SET_MODE_FILTER, SECCOMP_FILTER_FLAG_TSYNC, *page, 0, 0, 0}) == 0;
}

#else

HeldThread::HeldThread(pid_t thread) : thread_(thread) {}
HeldThread::~HeldThread() = default;
std::optional<std::int64_t> HeldThread::call(std::int64_t, const std::array<std::int64_t, 6>&) {
  return std::nullopt;
}
void HeldThread::end() {}
bool fail_system_call(HeldThread&, pid_t, int, int) { return false; }

#endif

}  // namespace strobe::ends
