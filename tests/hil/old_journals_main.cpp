// strobe-old-journals: the shipped strobed in a session folder with many large journals of earlier boots, and
// hosts that ask for all of them all the time. Prints the longest pause of STATUS, the time to READY and the
// worker's memory. By hand: it writes as much as it is told to.
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <sstream>
#include <string>

#include "common/messages/channels.hpp"
#include "firmware/publisher/journal.hpp"
#include "tests/hil/raw_host.hpp"
#include "tests/hil/rig_fixture.hpp"
#include "tests/support/private_network.hpp"
#include "tests/support/temporary_folder.hpp"

using namespace strobe;
using namespace strobe::hil;

namespace {

constexpr int kDone = 0, kFailed = 1;
constexpr std::int64_t kAskAgain_ns = 250'000'000;  // as strobe's own
constexpr std::int64_t kMaxEventsPerAsk = 512;
constexpr int kMaxAsks = 8;

firmware::Message event(std::int64_t boot_id, std::int64_t sequence, std::int32_t shot_id) {
  firmware::Event content;
  content.kind = firmware::EventKind::flash;
  content.shot_id = shot_id;
  const auto message = to_message(content, boot_id, sequence);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return {firmware::Message::Kind::event, {sequence, sequence}, "STROBE/bench/EVENT", std::move(bytes)};
}

/// Written to the disk, and no longer in memory, as after a start of the machine. Returns its last sequence.
std::int64_t write_journal(const std::filesystem::path& folder, std::int64_t boot_id, std::uintmax_t size) {
  auto journal = firmware::Journal::create(folder, boot_id);
  std::int64_t sequence = 0;
  while (std::filesystem::file_size(journal->path()) < size) {
    std::vector<firmware::Message> messages;
    while (messages.size() < 10'000) {
      ++sequence;
      messages.push_back(event(boot_id, sequence, static_cast<std::int32_t>(sequence / 1000 + 1)));
    }
    if (!journal->append(messages, boot_id * 1'000'000).has_value())
      throw std::runtime_error("the disk is full");
  }
  const int fd = open(journal->path().c_str(), O_RDONLY | O_CLOEXEC);
  fsync(fd);
  posix_fadvise(fd, 0, 0, POSIX_FADV_DONTNEED);
  close(fd);
  return sequence;
}

/// A line of /proc/PID/status [kB].
long memory(pid_t pid, const std::string& name) {
  std::istringstream status(testing::read_text("/proc/" + std::to_string(pid) + "/status"));
  for (std::string line; std::getline(status, line);)
    if (line.starts_with(name + ":")) return std::stol(line.substr(name.size() + 1));
  return 0;
}

/// When STATUS came, and the longest time between two.
struct StatusListener {
  std::int64_t last_ns = 0, longest_ns = 0, count = 0;
  void take(const lcm::ReceiveBuffer*, const std::string&, const strobe_msgs::status_t*) {
    const std::int64_t now = testing::monotonic_now_ns();
    if (last_ns != 0) longest_ns = std::max(longest_ns, now - last_ns);
    last_ns = now;
    ++count;
  }
};

struct Plan {
  int boots = 100, hosts = 3, seconds = 60;
  std::uintmax_t megabytes = 100;
};

/// Asks as strobe does, for all that every boot in the status has, each time for other parts of it.
void ask(RawHost& host, std::int64_t round) {
  for (const auto& boot : host.status().earlier) {
    for (int k = 0; k < kMaxAsks; ++k) {
      auto command = host.command(strobe_msgs::command_t::RESEND);
      command.resend_boot_id = boot.boot_id;
      command.resend_first = 1 + (round * kMaxAsks + k) * 7919 * kMaxEventsPerAsk % boot.last_sequence;
      command.resend_last = command.resend_first + kMaxEventsPerAsk - 1;
      host.send(command);
    }
  }
}

int run(const Plan& plan) {
  const testing::TemporaryFolder journals;
  for (int k = 1; k <= plan.boots; ++k) write_journal(journals.path(), k, plan.megabytes * 1'000'000);
  RigFixtureOptions options;
  options.shell = "for file in " + (journals.path() / "*.lcmlog").string() +
                  "; do [ ! -e \"$file\" ] || mv \"$file\" \"$5\"; done; exec \"$@\"";
  const std::int64_t begin = testing::monotonic_now_ns();
  RigFixture bench(options);
  if (!bench.ready()) {
    fmt::print(stderr, "strobed did not come up:\n{}\n", bench.log());
    return kFailed;
  }
  const double ready_s = static_cast<double>(testing::monotonic_now_ns() - begin) / 1e9;
  std::vector<std::unique_ptr<RawHost>> hosts;
  for (int k = 0; k < plan.hosts; ++k) {
    hosts.push_back(std::make_unique<RawHost>(bench));
    if (!hosts.back()->wait_status()) return kFailed;
  }
  lcm::LCM lcm(bench.lcm_url());
  StatusListener listener;
  lcm.subscribe(messages::channel_name("bench", messages::Channel::status), &StatusListener::take, &listener);
  std::int64_t rounds = 0, next = 0;
  const std::int64_t end = testing::monotonic_now_ns() + std::int64_t{plan.seconds} * 1'000'000'000;
  while (testing::monotonic_now_ns() < end) {
    lcm.handleTimeout(20);
    if (testing::monotonic_now_ns() < next) continue;
    next = testing::monotonic_now_ns() + kAskAgain_ns;
    for (std::size_t k = 0; k < hosts.size(); ++k) ask(*hosts[k], rounds * plan.hosts + static_cast<int>(k));
    ++rounds;
  }
  fmt::print("{} boots of {} MB, {} hosts that asked {} times each\n", plan.boots, plan.megabytes, plan.hosts,
             rounds * kMaxAsks * static_cast<std::int64_t>(hosts.front()->status().earlier.size()));
  fmt::print("start of the simulator to READY {:.2f} s\n", ready_s);
  fmt::print("STATUS: {} in {} s, longest pause {:.0f} ms\n", listener.count, plan.seconds,
             static_cast<double>(listener.longest_ns) / 1e6);
  fmt::print("worker: resident {} MB\n", memory(bench.worker(), "VmRSS") / 1000);
  return kDone;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Measures strobed in a folder of large old journals that hosts ask for all the time.");
  Plan plan;
  app.add_option("--boots", plan.boots, "earlier boots (default 100)");
  app.add_option("--megabytes", plan.megabytes, "of each journal (default 100)");
  app.add_option("--hosts", plan.hosts, "that ask (default 3)");
  app.add_option("--seconds", plan.seconds, "for which they ask (default 60)");
  CLI11_PARSE(app, argc, argv);
  const testing::IsolatedEnvironment isolated;
  return run(plan);
}
