#include "firmware/worker/worker.hpp"

#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <functional>
#include <future>
#include <memory>
#include <stdexcept>
#include <thread>

#include "common/messages/channels.hpp"
#include "firmware/core/sequencer.hpp"
#include "firmware/linux/console.hpp"
#include "firmware/linux/core_watch.hpp"
#include "firmware/linux/event_fd.hpp"
#include "firmware/linux/real_time.hpp"
#include "firmware/linux/signals.hpp"
#include "firmware/linux/sleep_inhibitor.hpp"
#include "firmware/linux/system_clock.hpp"
#include "firmware/linux/system_files.hpp"
#include "firmware/linux/tick_finder.hpp"
#include "firmware/publisher/command_feed.hpp"
#include "firmware/publisher/journal_folder.hpp"
#include "firmware/publisher/lcm_bus.hpp"
#include "firmware/publisher/publisher.hpp"
#include "firmware/publisher/receiver.hpp"

namespace strobe::firmware {

namespace {

std::string no_lcm(const std::string& url) {
  return "LCM cannot use \"" + url + "\": is there a multicast route? (ip route add 224.0.0.0/4 dev lo)";
}

std::string joined(const std::vector<std::string>& faults) {
  std::string all;
  for (const std::string& fault : faults) all += (all.empty() ? "" : "; ") + fault;
  return all;
}

void wait_for_stop_signal() {
  const sigset_t set = worker_stop_signals();
  int signal = 0;
  sigwait(&set, &signal);
}

/// Wakes the loop when the guardian dies. For good: it waits as long as the process lasts.
void watch_guardian(SharedStatus& page, std::shared_ptr<EventFd> wake, int priority) {
  std::thread([&page, wake = std::move(wake), priority] {
    become_real_time(priority);
    if (!page.guardian.wait_for_death()) return;
    wake->wake();
    if (getppid() == page.guardian_pid)
      kill(page.guardian_pid, SIGKILL);  // should it have been that thread alone
  }).detach();
}

/// The real-time thread: set up before the first turn, ended by stop(), or by itself when it can no longer
/// keep the outputs safe: then the process gets the stop signal.
class LoopThread {
 public:
  LoopThread(Sequencer& sequencer, HeldOutputs& outputs, const Rig::RealTime& wanted, SharedStatus& page,
             EventFd& wake, Console& console)
      : sequencer_(sequencer), outputs_(outputs), page_(page), wake_(wake), console_(console) {
    thread_ = std::thread([this, wanted] {
      page_.loop.hold();
      run(wanted);
      page_.loop.let_go();
    });
  }
  /// Never started: ends without having touched an output.
  ~LoopThread() {
    if (!thread_.joinable()) return;
    go_.set_value(ShortText());
    thread_.join();
  }
  pid_t tid() const { return tid_; }  ///< once set up
  /// What could not be had of the thread's real-time rights.
  std::vector<std::string> set_up() { return set_up_.get_future().get(); }
  /// Returns once the levels of key and e-stop have been read: the first status is to tell them.
  void start(const ShortText& detail) {
    go_.set_value(detail);
    levels_read_.get_future().wait();
  }
  void hang() { hang_ = true; }                  ///< drill
  void lose_outputs() { lose_outputs_ = true; }  ///< drill: they can no longer be set
  /// False: it had not stopped in good order.
  bool stop() {
    stop_ = true;
    wake_.wake();
    thread_.join();
    return well_;
  }

 private:
  void run(const Rig::RealTime& wanted) noexcept {
    tid_ = gettid();
    std::vector<std::string> faults;
    for (const std::string& fault : {pin_to_cpu(wanted.cpu), become_real_time(wanted.priority)}) {
      if (!fault.empty()) faults.push_back(fault);
    }
    prefault_stack();
    set_up_.set_value(std::move(faults));
    const ShortText detail = go_.get_future().get();
    if (detail.empty()) return;
    const char* failure = sequencer_.start(detail) ? nullptr : kNoSwitchingOff;
    levels_read_.set_value();
    while (failure == nullptr && !stop_) failure = turn();
    // Whoever stops the process may do it because the guardian is gone.
    if (failure == nullptr) failure = guardian_fault();
    well_ = failure == nullptr;
    if (failure == kNoSwitchingOff) let_go();
    page_.outputs_safe = sequencer_.stop(well_ ? "stopped by a signal" : failure) && !page_.lines_released;
    if (well_) return;
    console_.say(std::string("stopped: ") + failure);
    kill(getpid(), SIGTERM);
  }

  /// Null, or why the loop must end.
  const char* turn() noexcept {
    page_.loop_cpu.store(sched_getcpu(), std::memory_order_relaxed);
    page_.loop_heartbeat_ns.store(to_ns(clock_.now()), std::memory_order_relaxed);
    page_.shot_under_way.store(sequencer_.state() == State::firing, std::memory_order_relaxed);
    while (hang_) pause();
    if (lose_outputs_.exchange(false, std::memory_order_relaxed)) outputs_.release();
    if (const char* fault = guardian_fault()) return fault;
    return sequencer_.step(kNoDeadline) ? nullptr : kNoSwitchingOff;
  }

  /// Without a guardian nobody would make the outputs safe if this process died.
  const char* guardian_fault() const noexcept {
    if (page_.guardian.holder_died()) return "the guardian died";
    const MonoTime turned = std::max(started_, from_ns(page_.guardian_heartbeat_ns));
    return clock_.now() - turned > kGuardianTimeout ? "the guardian hangs" : nullptr;
  }

  void let_go() noexcept {
    outputs_.release();
    page_.lines_released = true;
    page_.notify();
  }

  static constexpr const char* kNoSwitchingOff = "an output could not be switched off";

  Sequencer& sequencer_;
  HeldOutputs& outputs_;
  SharedStatus& page_;
  EventFd& wake_;
  Console& console_;
  mutable SystemClock clock_;
  const MonoTime started_ = clock_.now();
  std::atomic<bool> stop_{false};
  std::atomic<bool> hang_{false};
  std::atomic<bool> lose_outputs_{false};
  bool well_ = true;
  pid_t tid_ = 0;
  std::promise<std::vector<std::string>> set_up_;
  std::promise<ShortText> go_;
  std::promise<void> levels_read_;
  std::thread thread_;
};

/// What the publisher does in the middle of a shot when a drill asks for it.
std::function<void()> drill(const std::string& name, LoopThread& loop) {
  if (name == "publisher-exception") return [] { throw std::runtime_error("drill: the publisher fails"); };
  if (name == "publisher-hang") {
    return [] {
      for (;;) pause();
    };
  }
  if (name == "output-failure") return [&loop] { loop.lose_outputs(); };
  return [&loop] { loop.hang(); };
}

/// For PublisherSettings::culprit.
std::function<std::string(MonoTime, MonoTime)> culprits_of(const Rig::RealTime& wanted, pid_t loop,
                                                           Console& console) {
  const auto none = [](MonoTime, MonoTime) { return std::string(); };
  if (!clock_is_the_kernels()) return none;
  auto opened = CoreWatch::open(allowed_cpus(wanted.cpu, SystemFiles()), loop);
  if (!opened) {
    console.say("late flashes will not name what ran instead: " + opened.error().message);
    return none;
  }
  return [watch = std::make_shared<CoreWatch>(std::move(*opened))](MonoTime from, MonoTime to) {
    const Culprit culprit = watch->culprit(from, to);
    return culprit.kind == Culprit::Kind::unknown ? std::string() : in_words(culprit);
  };
}

}  // namespace

int run_worker(const Rig& rig, const Options& options, SharedStatus& page, RigDevice& device) {
  keep_memory();
  // What the journal's disk and the network complete in the kernel would come to the CPU that asked for it.
  exclude_cpu(rig.real_time.cpu);
  Console console;
  const auto shared_wake = std::make_shared<EventFd>();
  EventFd& loop_wake = *shared_wake;
  EventFd publisher_wake;
  // The outputs were taken inactive; only the loop sets them, so until it starts there is nothing to make
  // safe.
  const auto give_up = [&page, &console](const std::string& why) {
    page.outputs_safe = true;
    console.say(why);
    return kExitBadInput;
  };
  SystemClock clock;
  const auto ports = device.open_ports(clock, page, loop_wake.fd());
  if (!ports) {
    page.outputs_safe = device.confirms();
    console.say(ports.error().message);
    return kExitBadInput;
  }
  for (const std::string& warning : ports->warnings) console.say("warning: " + warning);

  lcm::LCM lcm(options.lcm_url);
  if (!lcm.good()) return give_up(no_lcm(options.lcm_url));
  const auto commands_in =
      CommandFeed::open(options.lcm_url, messages::channel_name(rig.name, messages::Channel::command));
  if (!commands_in) return give_up(commands_in.error().message);
  const std::int64_t boot_id = random_id();
  page.boot_id = boot_id;
  LcmBus network(lcm);
  SealedBus bus(network, options.key.value(), boot_id);
  LoopQueue queue(rig, publisher_wake);
  CommandQueue commands(loop_wake);
  Mailbox mailbox;
  const FolderFindings earlier = repair_journals(options.session);
  for (const std::string& line : earlier.repaired) console.say(line);
  ShotNumbers numbers(options.session, earlier.last_shot_id);
  // Before the loop runs: with none set aside it refuses shots until the publisher could.
  if (auto done = numbers.set_aside(numbers.last_before()); !done) console.say(done.error().message);
  queue.set_shot_id_limit(numbers.limit());
  Sequencer sequencer(rig, {clock, ports->outputs, ports->edges, queue, commands}, numbers.last_before(),
                      rig.played_by_chip() ? Tick{} : find_tick(rig.real_time));

  std::vector<std::string> faults;
  if (std::string fault = lock_memory(); !fault.empty()) faults.push_back(std::move(fault));
  const LatencyRequest latency;
  LoopThread loop(sequencer, device, rig.real_time, page, loop_wake, console);
  for (std::string& fault : loop.set_up()) faults.push_back(std::move(fault));
  if (!faults.empty() && !options.allow_no_rt) {
    return give_up("no real-time rights: " + joined(faults) +
                   "; or start with --allow-no-rt and worse timing");
  }
  if (!latency.fault().empty()) faults.push_back(latency.fault());
  for (const std::string& fault : faults) console.say("warning: " + fault);

  auto journal = Journal::create(options.session, boot_id);
  if (!journal) return give_up(journal.error().message);
  const auto say = [&console](const std::string& line) { console.say(line); };
  Rejections rejections(clock, say);
  PublisherSettings settings;
  settings.rejected = [&rejections] { return rejections.counts(); };
  settings.boot_id = boot_id;
  settings.session = options.session;
  settings.say = say;
  settings.found = earlier;
  settings.numbers = &numbers;
  settings.real_time = faults.empty();
  settings.verbose = options.verbose;
  settings.heartbeat_ns = &page.publisher_heartbeat_ns;
  settings.drill_at_shot = options.drill_at_shot;
  settings.drill = drill(options.drill, loop);
  settings.culprit = culprits_of(rig.real_time, loop.tid(), console);
  settings.on_first_status = [&rig, &options, &page, &console, boot_id] {
    console.say("ready, rig " + rig.name + ", boot " + boot_in_hex(boot_id) + ", key " + options.key_words);
    page.ready = true;
    page.notify();
  };
  SleepInhibitor sleep(say);
  settings.on_status = [&sleep, &clock](State state) {
    sleep.turn(state == State::armed || state == State::firing, clock.now());
  };
  Publisher publisher(rig, settings, queue, mailbox, *journal, bus, clock);
  Receiver receiver(rig, boot_id, options.key.value(), commands, mailbox, rejections, system_boot_time_ns,
                    random_id, &page.host_heard_ns);
  const CommandFeed::Handlers on_command{
      [&receiver](std::span<const std::uint8_t> sealed) { receiver.receive(sealed); },
      [&rejections] { rejections.note(authentication::Rejection::oversized); },
      [&rejections] { rejections.turn(); }};
  watch_guardian(page, shared_wake, rig.real_time.priority + 1);
  loop.start(ShortText("strobed " STROBE_VERSION)
                 .append(settings.real_time ? ", real time" : ", without all real-time rights"));
  // noexcept: an exception ends the process here and now, and the guardian makes the outputs safe.
  std::jthread publishing(
      [&](const std::stop_token& stop) noexcept { publisher.run(stop, publisher_wake.fd()); });
  std::jthread receiving(
      [&](const std::stop_token& stop) noexcept { (*commands_in)->run(stop, on_command); });

  become_real_time(rig.real_time.priority + 1);  // however busy the machine: a stop is at once
  wait_for_stop_signal();
  const bool well = loop.stop();
  become_ordinary();
  receiving.request_stop();
  receiving.join();
  publishing.request_stop();
  publisher_wake.wake();
  publishing.join();
  return well ? kExitDone : kExitFailed;
}

}  // namespace strobe::firmware
