#include "firmware/check.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/authentication/key_file.hpp"
#include "common/flash_sequencer/pio_programs.hpp"
#include "firmware/flash_sequencer/inspect.hpp"
#include "firmware/linux/guardian.hpp"
#include "firmware/linux/inspect_lines.hpp"
#include "firmware/linux/interrupts.hpp"
#include "firmware/linux/machine_verdict.hpp"
#include "firmware/linux/real_time_report.hpp"
#include "firmware/linux/smi_counter.hpp"
#include "firmware/linux/system_clock.hpp"
#include "firmware/linux/tick_finder.hpp"
#include "firmware/rp1_pio/dev_pio.hpp"
#include "firmware/worker/service_files.hpp"

namespace strobe::firmware {

namespace {

using Verdict = CheckItem::Verdict;

class Report {
 public:
  explicit Report(bool json) : json_(json) {}
  /// tolerated: a fault that this start would put up with.
  void item(const CheckItem& item, bool tolerated = false) {
    const bool well = item.verdict == Verdict::ok;
    const bool advised = item.verdict == Verdict::advice;
    if (!well && !advised && !tolerated) ++faults_;
    for (const std::string& line : item.paste)
      if (std::find(paste_.begin(), paste_.end(), line) == paste_.end()) paste_.push_back(line);
    if (json_) {
      const nlohmann::json object{{"item", item.name},
                                  {"ok", well},
                                  {"tolerated", advised || (tolerated && !well)},
                                  {"what", well ? "" : item.words},
                                  {"found", well ? item.words : ""},
                                  {"paste", item.paste}};
      std::printf("%s\n", object.dump().c_str());
    } else {
      const std::string before = well        ? (item.words.empty() ? "ok" : "ok: ")
                                 : advised   ? "advice: "
                                 : tolerated ? "tolerated: "
                                             : "";
      std::printf("%-16s %s%s\n", item.name.c_str(), before.c_str(), item.words.c_str());
    }
  }
  void item(const std::string& name, const std::string& fault) {
    item({name, fault.empty() ? Verdict::ok : Verdict::fault, fault});
  }
  int faults() const { return faults_; }
  /// What can be done about it all, in lines to paste.
  void print_lines_to_paste() const {
    if (json_ || paste_.empty()) return;
    std::printf("\nTo paste into root's shell (the kernel and its command line count after a reboot):\n");
    for (const std::string& line : paste_) std::printf("%s\n", line.c_str());
  }

 private:
  bool json_;
  int faults_ = 0;
  std::vector<std::string> paste_;
};

std::string session_fault(const std::filesystem::path& session) {
  if (session.empty()) return "--session is required: the folder for the journal";
  std::error_code error;
  std::filesystem::path existing = std::filesystem::absolute(session);
  while (!std::filesystem::exists(existing, error) && existing.has_relative_path())
    existing = existing.parent_path();
  if (!std::filesystem::is_directory(existing, error)) return existing.string() + " is not a folder";
  if (access(existing.c_str(), W_OK | X_OK) != 0)
    return existing.string() + " cannot be written by this user";
  const auto space = std::filesystem::space(existing, error);
  constexpr std::uintmax_t kMin = std::uintmax_t{100} << 20;  // some 500 shots
  if (!error && space.available < kMin) {
    return existing.string() + " has only " + std::to_string(space.available >> 20) + " MiB left";
  }
  return "";
}

/// What its calls take: as well as that the start of a train is known.
CheckItem pio_item(const Rig& rig) {
  namespace pio = flash_sequencer::pio;
  constexpr std::size_t kCalls = 200;
  const auto block = DevPio::open(rig);
  if (!block) return {"chip.pio", Verdict::fault, block.error().message};
  SystemClock clock;
  std::array<Duration, kCalls> took;
  for (Duration& each : took) {
    const MonoTime before = clock.now();
    if (!(*block)->execute(0, pio::mov(pio::To::y, pio::From::y)))
      return {"chip.pio", Verdict::fault, rig.pio.device + " does not do as it is told"};
    each = clock.now() - before;
  }
  std::sort(took.begin(), took.end());
  const auto in_us = [&](std::size_t index) { return std::to_string(took.at(index) / microseconds(1)); };
  return {"chip.pio", Verdict::ok,
          rig.pio.device + ": a call takes " + in_us(kCalls / 2) + " us (99 %: " + in_us(kCalls * 99 / 100) +
              " us)"};
}

Result<CulpritOf> watch_cores(const std::set<int>& cpus, pid_t tid) {
  auto watch = CoreWatch::open(cpus, tid);
  if (!watch) return tl::unexpected(watch.error());
  auto shared = std::make_shared<CoreWatch>(std::move(*watch));
  return [shared](MonoTime from, MonoTime to) { return shared->culprit(from, to); };
}

/// On standard error, for a person who waits.
void tell_progress(Duration passed, Duration length) {
  if (length <= milliseconds(2000) || isatty(STDERR_FILENO) == 0) return;
  const bool over = passed >= length;
  std::fprintf(stderr, over ? "\r\033[K" : "\rtrying the machine: %d of %d s ",
               static_cast<int>(to_seconds(passed)), static_cast<int>(to_seconds(length)));
}

void report_machine(const Rig& rig, const Options& options, Report& report) {
  if (options.trial == Duration{}) return;
  if (!clock_is_the_kernels())
    return report.item({"machine", Verdict::advice, "not tried: a simulated rig has a time of its own"});
  exclude_cpu(rig.real_time.cpu);
  const std::set<int> cpus = allowed_cpus(rig.real_time.cpu, SystemFiles());
  const MachineCounters before = read_counters(cpus, SystemFiles());
  const SmiCounter smis(cpus, SystemFiles());
  const MachineTrial trial = try_machine(rig, cpus, options.trial, watch_cores,
                                         [&](Duration passed) { tell_progress(passed, options.trial); });
  tell_progress(options.trial, options.trial);
  MachineCounters after = read_counters(cpus, SystemFiles());
  after.smis = smis.count();
  for (const CheckItem& item : machine_verdict(rig, trial, before, after, SystemFiles()))
    report.item(item, options.allow_no_rt);
}

}  // namespace

int check_rig(const Rig& rig, const Options& given) {
  const Options options = options_of_check(given, rig, geteuid() == 0);
  Report report(options.json);
  report.item({"rig file", Verdict::ok, options.config});
  const bool by_chip = rig.played_by_chip();
  for (const CheckItem& item :
       rig.flash_sequencer.fitted() ? inspect_flash_sequencer(rig) : inspect_lines(rig, SystemFiles()))
    report.item(item);
  if (rig.pio.fitted()) report.item(pio_item(rig));
  const RealTimeRights trial = probe_real_time(rig.real_time);
  for (const CheckItem& item : real_time_report(
           rig, trial, !by_chip && trial.pinning.empty() ? find_tick(rig.real_time) : Tick{}, SystemFiles()))
    report.item(item, options.allow_no_rt);
  report.item(kernel_item(SystemFiles()));
  const std::string fault = session_fault(options.session);
  report.item(fault.empty() ? CheckItem{"session", Verdict::ok, options.session.string()}
                            : CheckItem{"session", Verdict::fault, fault});
  const auto key = authentication::find_key({options.key_file, rig.key_file});
  report.item(key ? CheckItem{"key", Verdict::ok,
                              key->path.string() + ", fingerprint " + key->key.fingerprint() +
                                  (key->made ? " (new)" : "") + key_note(options, rig)}
                  : CheckItem{"key", Verdict::fault, key.error().message});
  lcm::LCM lcm(options.lcm_url);
  report.item("lcm", lcm.good() ? ""
                                : "LCM cannot use \"" + options.lcm_url +
                                      "\": is there a multicast route? (ip route add 224.0.0.0/4 dev lo)");
  if (!by_chip) report_machine(rig, options, report);
  report.print_lines_to_paste();
  return report.faults() == 0 ? kExitDone : kExitFailed;
}

int move_interrupts(const Rig& rig) {
  if (rig.real_time.cpu < 0) {
    std::fprintf(stderr,
                 "strobed: --move-interrupts: the rig file names no CPU for the loop ([real_time] cpu)\n");
    return kExitBadInput;
  }
  const InterruptMoves moved = move_interrupts_off(rig.real_time.cpu, SystemFiles());
  const auto print = [](const char* what, const std::vector<Interrupt>& interrupts) {
    for (const Interrupt& interrupt : interrupts)
      std::printf("%-9s %d %s\n", what, interrupt.number, interrupt.name.c_str());
  };
  print("moved", moved.away);
  print("refused", moved.refused);
  print("fixed", moved.fixed);
  std::printf("%-9s interrupts that are requested later\n",
              moved.newcomers_kept_off ? "kept off" : "refused");
  return moved.refused.empty() && moved.newcomers_kept_off ? kExitDone : kExitFailed;
}

}  // namespace strobe::firmware
