#include "firmware/linux/interrupts.hpp"

namespace strobe::firmware {

namespace {

const std::string kNewcomers = "proc/irq/default_smp_affinity";

std::string folder_of(int number) { return "proc/irq/" + std::to_string(number); }

std::string affinity_file(int number) { return folder_of(number) + "/smp_affinity_list"; }

std::string users_of(int number, const SystemFiles& files) {
  if (auto actions = files.read("sys/kernel/irq/" + std::to_string(number) + "/actions");
      actions && !actions->empty())
    return *actions;
  std::string names;
  for (const std::string& entry : files.list(folder_of(number))) {
    if (files.is_folder(folder_of(number) + "/" + entry)) names += (names.empty() ? "" : ",") + entry;
  }
  return names;
}

}  // namespace

std::vector<Interrupt> read_interrupts(const SystemFiles& files) {
  std::vector<Interrupt> all;
  for (const std::string& entry : files.list("proc/irq")) {
    if (!is_number(entry)) continue;
    Interrupt interrupt;
    interrupt.number = std::atoi(entry.c_str());
    const auto list = files.read(affinity_file(interrupt.number));
    if (!list) continue;
    interrupt.cpus = parse_cpu_list(*list);
    interrupt.name = users_of(interrupt.number, files);
    // Since Linux 6.4 the mode says it; before, only an attempt does.
    interrupt.movable = files.owner_may_write(affinity_file(interrupt.number));
    all.push_back(std::move(interrupt));
  }
  return all;
}

bool newcomers_may_run_on(int cpu, const SystemFiles& files) {
  return parse_cpu_mask(files.read(kNewcomers).value_or("")).contains(cpu);
}

namespace {

/// Before those that there are: one that comes meanwhile is then among them or kept off.
bool keep_newcomers_off(int cpu, const SystemFiles& files) {
  if (!newcomers_may_run_on(cpu, files)) return true;
  std::set<int> rest = parse_cpu_mask(files.read(kNewcomers).value_or(""));
  rest.erase(cpu);
  return !rest.empty() && files.write(kNewcomers, format_cpu_mask(rest)) && !newcomers_may_run_on(cpu, files);
}

}  // namespace

InterruptMoves move_interrupts_off(int cpu, const SystemFiles& files) {
  InterruptMoves moved;
  moved.newcomers_kept_off = keep_newcomers_off(cpu, files);
  const std::set<int> online = parse_cpu_list(files.read("sys/devices/system/cpu/online").value_or("0"));
  for (Interrupt& interrupt : read_interrupts(files)) {
    if (!interrupt.cpus.contains(cpu)) continue;
    std::set<int> rest = interrupt.cpus;
    rest.erase(cpu);
    if (rest.empty()) rest = online;
    rest.erase(cpu);
    const std::string file = affinity_file(interrupt.number);
    if (!interrupt.movable) {
      moved.fixed.push_back(std::move(interrupt));
    } else if (!rest.empty() && files.write(file, format_cpu_list(rest)) &&
               !parse_cpu_list(files.read(file).value_or("")).contains(cpu)) {
      moved.away.push_back(std::move(interrupt));
    } else {
      moved.refused.push_back(std::move(interrupt));
    }
  }
  return moved;
}

}  // namespace strobe::firmware
