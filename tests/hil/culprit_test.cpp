// A shot that another thread makes late names that thread: a real-time thread takes the loop's CPU in mid-train.
#include <pthread.h>
#include <sched.h>

#include <atomic>
#include <cstdio>
#include <future>
#include <string>
#include <thread>

#include "firmware/linux/core_watch.hpp"
#include "firmware/linux/system_files.hpp"
#include "tests/hil/raw_host.hpp"
#include "tests/support/skip.hpp"

#include "tests/hil/expectations.hpp"
#include <CppUTest/TestHarness.h>

using namespace strobe::hil;
using namespace std::chrono_literals;
using strobe::testing::monotonic_now_ns;
using strobe::testing::skip;

namespace {

constexpr const char* kName = "core-hog";
constexpr int kPriority = 95;  // above the loop's
constexpr std::int64_t kHeldNs = 30 * kMs;

/// Whether the calling thread may be of that priority, on that CPU.
bool take(int cpu) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(static_cast<unsigned>(cpu), &set);
  const sched_param param{.sched_priority = kPriority};
  return pthread_setaffinity_np(pthread_self(), sizeof set, &set) == 0 &&
         pthread_setschedparam(pthread_self(), SCHED_FIFO, &param) == 0;
}

/// Takes a CPU half of the time, however busy the machine: a train of 200 ms meets it several times.
class Hog {
 public:
  explicit Hog(int cpu)
      : thread_([this, cpu] {
          pthread_setname_np(pthread_self(), kName);
          taken_.set_value(take(cpu));
          while (!leave_) {
            for (const std::int64_t until = monotonic_now_ns() + kHeldNs; monotonic_now_ns() < until;) continue;
            std::this_thread::sleep_for(std::chrono::nanoseconds(kHeldNs));
          }
        }) {}
  ~Hog() {
    leave_ = true;
    thread_.join();
  }
  bool may() { return taken_.get_future().get(); }

 private:
  std::promise<bool> taken_;
  std::atomic<bool> leave_{false};
  std::thread thread_;
};

}  // namespace

TEST_GROUP(Culprit){};

TEST(Culprit, AShotThatAnotherThreadMadeLateNamesIt) {
  const int cpu = *strobe::firmware::parse_cpu_list(
                       strobe::firmware::SystemFiles().read("sys/devices/system/cpu/online").value_or("0"))
                       .rbegin();
  if (const auto watch = strobe::firmware::CoreWatch::open({cpu}, gettid()); !watch)
    return skip(watch.error().message);
  RigFixtureOptions options;
  options.sim_options = {"--time", "real"};
  options.rig_edits = {{"cpu = -1 ", "cpu = " + std::to_string(cpu) + " "}};
  ReadyRig bench(options);
  RawHost host(bench);
  CHECK(host.wait_status());
  std::string reason;
  // A virtual machine's core may stand still before the thread comes, or while the loop sleeps.
  const auto stood_still = [&reason] {
    return reason.find("stood still") != reason.npos || reason.find("it slept") != reason.npos;
  };
  for (int shot = 0; shot < kRetriesInRealTime && (shot == 0 || stood_still()); ++shot) {
    const std::int64_t token = host.arm();
    CHECK_TEXT(token != 0, host.status().message.c_str());
    Hog hog(cpu);
    if (!hog.may()) return skip("this machine gives no real-time priority");
    const std::size_t shots = host.shots().size();
    host.send(host.fire_command(token, true));
    CHECK(host.wait([&] { return host.shots().size() > shots; }, kLongestWait));
    reason = host.shots().back().abort_reason;
    std::printf(" %s\n", reason.c_str());
  }
  STRCMP_CONTAINS((std::string(" us late: ") + kName + " (pid ").c_str(), reason.c_str());
  for (const auto& event : host.events())
    if (event.kind == strobe_msgs::event_t::SHOT_ABORTED && event.shot_id == host.shots().back().shot_id)
      STRCMP_EQUAL(reason.c_str(), event.detail.c_str());
}
