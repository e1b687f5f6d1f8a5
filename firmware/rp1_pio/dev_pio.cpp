#include "firmware/rp1_pio/dev_pio.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "firmware/linux/real_time.hpp"
#include "firmware/linux/rig_lines.hpp"

namespace strobe::firmware {

namespace {

// What the driver's requests carry, with its layout.
struct ProgramArguments {
  std::uint16_t count = 0, origin = 0;
  std::array<std::uint16_t, PioBlock::kInstructionCount> instructions{};
};
struct MaskArguments {
  std::uint16_t machines = 0;
};
struct SetUpArguments {
  std::uint16_t machine = 0, address = 0;
  PioBlock::Registers registers;
};
struct ExecuteArguments {
  std::uint16_t machine = 0, instruction = 0;
  std::uint8_t blocking = 0, reserved = 0;
};
struct EnableArguments {
  std::uint16_t machines = 0;
  std::uint8_t enable = 0, reserved = 0;
};
struct GetArguments {
  std::uint16_t machine = 0;
  std::uint8_t blocking = 0, reserved = 0;
  std::uint32_t word = 0;
};
struct QueueArguments {
  std::uint16_t machine = 0;
  std::uint8_t to_machine = 0, reserved = 0;
  std::uint16_t level = 0;
  std::uint8_t empty = 0, full = 0;
};
struct FunctionArguments {
  std::uint16_t pin = 0, function = 0;
};
struct ChannelArguments {
  std::uint16_t machine = 0, direction = 0, buffer_bytes = 0, buffers = 0;
};
struct TransferArguments {
  std::uint16_t machine = 0, direction = 0, bytes = 0, reserved = 0;
  const void* words = nullptr;
};

constexpr unsigned kMagic = 102;
constexpr unsigned long kConfigureChannel = _IOW(kMagic, 0, ChannelArguments);
constexpr unsigned long kTransfer = _IOW(kMagic, 1, TransferArguments);
constexpr unsigned long kAddProgram = _IOW(kMagic, 11, ProgramArguments);
constexpr unsigned long kIsClaimed = _IOW(kMagic, 22, MaskArguments);
constexpr unsigned long kSetUp = _IOW(kMagic, 30, SetUpArguments);
constexpr unsigned long kExecute = _IOW(kMagic, 32, ExecuteArguments);
constexpr unsigned long kSetEnabled = _IOW(kMagic, 37, EnableArguments);
constexpr unsigned long kEnableInSync = _IOW(kMagic, 40, MaskArguments);
constexpr unsigned long kGet = _IOWR(kMagic, 42, GetArguments);
constexpr unsigned long kQueueState = _IOW(kMagic, 44, QueueArguments);  // writes, whatever its number says
constexpr unsigned long kSetFunction = _IOW(kMagic, 51, FunctionArguments);

constexpr std::uint16_t kPioFunction = 7;
constexpr std::uint16_t kToMachine = 0;
/// A whole train lies in it, so that nothing but the DMA is needed once it has been handed over.
constexpr std::uint16_t kBufferBytes = DevPio::kMaxWords * sizeof(std::uint32_t);

constexpr std::uint16_t narrow(unsigned value) { return static_cast<std::uint16_t>(value); }

int kernel_ioctl(int fd, unsigned long request, void* argument) { return ::ioctl(fd, request, argument); }

std::string words_of_open(int error) {
  if (error == ENOENT || error == ENXIO)
    return "is not there: this takes a Raspberry Pi 5, its kernel and its boot firmware of 2025 or newer "
           "(sudo apt full-upgrade, sudo rpi-eeprom-update -a, restart)";
  if (error == EACCES || error == EPERM)
    return std::string("cannot be opened: ") + std::strerror(error) + " (" + kAllowUser + ")";
  return std::string("cannot be opened: ") + std::strerror(error);
}

}  // namespace

Result<std::unique_ptr<DevPio>> DevPio::open(const Rig& rig) {
  const auto failed = [&](const std::string& what) {
    return fail(place(rig, rig.pio.file_line, "chip.pio") + "\"" + rig.pio.device + "\" " + what);
  };
  const int fd = ::open(rig.pio.device.c_str(), O_RDWR | O_CLOEXEC);
  if (fd < 0) return failed(words_of_open(errno));
  auto block = std::make_unique<DevPio>(fd, kernel_ioctl);
  if (flock(fd, LOCK_EX | LOCK_NB) != 0) return failed("is in use by another program");
  if (const std::string why = block->in_use(); !why.empty()) return failed(why);
  return block;
}

std::string DevPio::in_use() {
  for (unsigned machine = 0; machine < kMachineCount; ++machine) {
    // The driver writes back as many bytes as its answer says, whatever the argument's size.
    std::array<std::uint16_t, 8> mask{narrow(1U << machine)};
    const int claimed = ioctl_(fd_, kIsClaimed, mask.data());
    if (claimed < 0 && errno == ENOTTY) return "is no PIO block";
    if (claimed < 0) return std::string("does not answer: ") + std::strerror(errno);
    if (claimed > 0) return "has machines that another program uses: end it, all four are needed";
  }
  return {};
}

void DevPio::release() noexcept {
  for (Mover& mover : movers_) {
    mover.task = Task::stop;
    mover.task.notify_one();
  }
  for (Mover& mover : movers_) {
    if (mover.thread.joinable()) mover.thread.join();
  }
  if (const int fd = fd_.exchange(-1); fd >= 0) close(fd);
}

bool DevPio::load(std::span<const std::uint16_t> program) noexcept {
  ProgramArguments arguments{.count = narrow(static_cast<unsigned>(program.size()))};
  if (program.size() > arguments.instructions.size()) return false;
  std::copy(program.begin(), program.end(), arguments.instructions.begin());
  return ask(kAddProgram, arguments);
}

bool DevPio::set_up(unsigned machine, const Registers& registers, unsigned address) noexcept {
  SetUpArguments arguments{narrow(machine), narrow(address), registers};
  return disable(1U << machine) && ask(kSetUp, arguments);
}

bool DevPio::execute(unsigned machine, std::uint16_t instruction) noexcept {
  ExecuteArguments arguments{.machine = narrow(machine), .instruction = instruction};
  return ask(kExecute, arguments);
}

bool DevPio::enable(unsigned machines) noexcept {
  MaskArguments mask{narrow(machines)};
  return ask(kEnableInSync, mask);
}

bool DevPio::disable(unsigned machines) noexcept {
  EnableArguments arguments{.machines = narrow(machines)};
  return ask(kSetEnabled, arguments);
}

bool DevPio::drive(unsigned pin) noexcept {
  FunctionArguments arguments{narrow(pin), kPioFunction};
  return ask(kSetFunction, arguments);
}

/// An empty queue is asked for first: what the driver gives of one is no word.
std::optional<std::uint32_t> DevPio::get(unsigned machine) noexcept {
  QueueArguments queue{.machine = narrow(machine)};
  if (!ask(kQueueState, queue) || queue.empty != 0) return std::nullopt;
  GetArguments arguments{.machine = narrow(machine)};
  return ask(kGet, arguments) ? std::optional(arguments.word) : std::nullopt;
}

// ---- transfers ----

void DevPio::start(int priority) {
  for (unsigned machine = 0; machine < kTransfers; ++machine)
    movers_[machine].thread = std::thread([this, machine, priority] { move(machine, priority); });
}

void DevPio::move(unsigned machine, int priority) noexcept {
  become_real_time(priority);  // what is wrong with the rights is told of the loop's
  prefault_stack();
  Mover& mover = movers_[machine];
  for (;;) {
    mover.task.wait(Task::none);
    if (mover.task == Task::stop) return;
    TransferArguments arguments{.machine = narrow(machine),
                                .direction = kToMachine,
                                .bytes = narrow(static_cast<unsigned>(mover.words.size_bytes())),
                                .words = mover.words.data()};
    // It fails when the transfer takes more than a second, which goes on all the same.
    if (!ask(kTransfer, arguments)) mover.outlasted = true;
    Task asked = Task::asked;  // unless it is to stop
    mover.task.compare_exchange_strong(asked, Task::none);
  }
}

/// A channel is configured once: the driver of kernels before July 2026 sleeps with a spinlock held where a
/// channel is configured anew.
bool DevPio::transfer(unsigned machine, std::span<const std::uint32_t> words) noexcept {
  if (machine >= kTransfers || words.size() > kMaxWords) return false;
  Mover& mover = movers_[machine];
  if (!mover.thread.joinable() || mover.task != Task::none) return false;
  ChannelArguments arguments{narrow(machine), kToMachine, kBufferBytes, 1};
  mover.configured = mover.configured || ask(kConfigureChannel, arguments);
  if (!mover.configured) return false;
  mover.words = words;
  mover.task = Task::asked;
  mover.task.notify_one();
  return begun(machine, words.size());
}

/// Whether the machine's queue has the first words, by and by.
bool DevPio::begun(unsigned machine, std::size_t words) noexcept {
  constexpr std::size_t kFirst = 4;  ///< that the DMA brings at once
  constexpr int kTries = 500;        ///< of some 10 us
  for (int tries = 0; tries < kTries; ++tries) {
    const auto level = queued(machine);
    if (!level) return false;
    if (*level >= std::min(words, kFirst)) return true;
  }
  return false;
}

/// Once a request has ended before its transfer, the driver takes each later one to be over when the one
/// before is: then it is over when nothing has come for longer than a whole train takes.
bool DevPio::transferring(unsigned machine) noexcept {
  if (machine >= kTransfers || movers_[machine].task != Task::none) return machine < kTransfers;
  constexpr int kLooks = 500;  ///< of some us
  for (int look = 0; look < (movers_[machine].outlasted ? kLooks : 1); ++look)
    if (queued(machine).value_or(1) != 0) return true;
  return false;
}

std::optional<unsigned> DevPio::queued(unsigned machine) noexcept {
  QueueArguments queue{.machine = narrow(machine), .to_machine = 1};
  return ask(kQueueState, queue) ? std::optional<unsigned>(queue.level) : std::nullopt;
}

}  // namespace strobe::firmware
