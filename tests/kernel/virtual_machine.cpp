#include "tests/kernel/virtual_machine.hpp"

#include <cstdio>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace strobe::kernel {

namespace {

testing::Command qemu_command(const std::filesystem::path& boot, const std::filesystem::path& folder) {
  const auto at = [&folder](const char* name) { return (folder / name).string(); };
  testing::Command command;
  command.arguments = {
      "qemu-system-aarch64",
      "-M",
      "virt",
      "-accel",
      "tcg",
      "-cpu",
      "cortex-a57",
      "-smp",
      "1",
      "-m",
      "512",
      "-display",
      "none",
      "-nodefaults",
      "-no-reboot",
      "-kernel",
      boot / "vmlinuz",
      "-initrd",
      boot / "initrd",
      "-append",
      "console=ttyAMA0 quiet panic=-1",
      "-serial",
      "unix:" + at("serial"),
      "-qtest",
      "unix:" + at("lines"),
      "-qtest-log",
      "/dev/null",
      "-qmp",
      "unix:" + at("monitor"),
      "-netdev",
      "dgram,id=cable,local.type=unix,local.path=" + VirtualMachine::cable_there(folder).string() +
          ",remote.type=unix,remote.path=" + VirtualMachine::cable_here(folder).string(),
      "-device",
      "virtio-net-device,netdev=cable"};
  if (std::filesystem::exists(boot / "disk")) {
    command.arguments.insert(
        command.arguments.end(),
        {"-drive", "if=none,id=disk,format=raw,snapshot=on,file=" + (boot / "disk").string(), "-device",
         "virtio-blk-device,drive=disk"});
  }
  return command;
}

}  // namespace

VirtualMachine::VirtualMachine(const std::filesystem::path& boot, const std::filesystem::path& folder)
    : folder_(folder),
      serial_(folder / "serial"),
      test_(folder / "lines"),
      monitor_(folder / "monitor"),
      qemu_(std::make_unique<testing::Process>(qemu_command(boot, folder), folder)) {
  try {
    monitor_.accept(kTimeout);
    test_.accept(kTimeout);
    serial_.accept(kTimeout);
    chip_ = find_chip();
    if (ask_lines("irq_intercept_out " + chip_) != "OK") throw std::runtime_error("lines cannot be watched");
    while (wait_for_line() != "<ready>") continue;
    run("true");  // the shell has said hello
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(std::string("no virtual machine: ") + error.what() + "\n" + qemu_->err() + log_);
  }
}

VirtualMachine::~VirtualMachine() { qemu_->signal(9); }  // nothing in it is to be kept

std::string VirtualMachine::wait_for_line() {
  const auto line = serial_.receive(kTimeout);
  if (!line) throw std::runtime_error("it says no more");
  log_ += *line + "\n";
  return *line;
}

std::string VirtualMachine::find_chip() {
  const auto ask = [this](const nlohmann::json& question) {
    monitor_.send(question.dump() + "\n");
    for (;;) {
      const auto line = monitor_.receive(kTimeout);
      if (!line) throw std::runtime_error("the monitor is silent");
      const auto answer = nlohmann::json::parse(*line);
      if (answer.contains("return")) return answer["return"];
      if (answer.contains("error")) throw std::runtime_error(*line);
    }
  };
  ask({{"execute", "qmp_capabilities"}});
  const std::string parent = "/machine/unattached";
  for (const auto& child : ask({{"execute", "qom-list"}, {"arguments", {{"path", parent}}}}))
    if (child.at("type") == "child<pl061>") return parent + "/" + child.at("name").get<std::string>();
  throw std::runtime_error("it has no PL061");
}

void VirtualMachine::keep_change(const std::string& line) {
  PinChange change;
  char verb[16] = {};
  if (std::sscanf(line.c_str(), "IRQ %15s %u", verb, &change.pin) != 2) return;
  change.level = std::string(verb) == "raise" ? 1 : 0;
  changes_.push_back(change);
}

std::string VirtualMachine::ask_lines(const std::string& command) {
  test_.send(command + "\n");
  for (;;) {
    const auto line = test_.receive(kTimeout);
    if (!line) throw std::runtime_error("no answer to: " + command);
    if (line->rfind("IRQ", 0) != 0) return *line;
    keep_change(*line);
  }
}

void VirtualMachine::drive(unsigned pin, int level) {
  ask_lines("set_irq_in " + chip_ + " unnamed-gpio-in " + std::to_string(pin) + " " + std::to_string(level));
}

std::optional<VirtualMachine::PinChange> VirtualMachine::next_change(std::chrono::milliseconds limit) {
  if (changes_.empty()) {
    if (const auto line = test_.receive(limit)) keep_change(*line);
  }
  if (changes_.empty()) return std::nullopt;
  const PinChange change = changes_.front();
  changes_.erase(changes_.begin());
  return change;
}

std::string VirtualMachine::run(const std::string& line, std::chrono::milliseconds limit) {
  const std::string end = "<done " + std::to_string(++commands_) + ">";
  // The end's text is put together there, so that an echo of the command is not taken for it.
  serial_.send(line + "\necho '<done' '" + std::to_string(commands_) + ">'\n");
  std::string printed;
  for (;;) {
    const auto got = serial_.receive(limit);
    if (!got) throw std::runtime_error("\"" + line + "\" does not end: " + printed);
    log_ += *got + "\n";
    if (got->size() >= end.size() && got->compare(got->size() - end.size(), end.size(), end) == 0)
      return printed;
    printed += *got + "\n";
  }
}

std::string VirtualMachine::log() const { return log_; }

}  // namespace strobe::kernel
