#include "host/commands/terminal.hpp"

#include <csignal>
#include <cstdio>
#include <ctime>
#include <random>

#include "common/messages/channels.hpp"
#include "common/messages/json_conversions.hpp"

namespace strobe::host {
namespace {

constexpr std::int64_t kRepaint_ns = 100'000'000;

volatile std::sig_atomic_t caught = 0;

void mark(int) { caught = 1; }

std::int64_t now_ns(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return static_cast<std::int64_t>(time.tv_sec) * 1'000'000'000 + time.tv_nsec;
}

}  // namespace

std::int64_t steady_now_ns() { return now_ns(CLOCK_MONOTONIC); }
ClockReading read_clocks() {
  return {now_ns(CLOCK_MONOTONIC), now_ns(CLOCK_REALTIME), now_ns(CLOCK_BOOTTIME)};
}
std::int64_t wall_now_us() { return now_ns(CLOCK_REALTIME) / 1000; }

std::int64_t random_host_id() {
  std::random_device device;
  const std::uint64_t bits = (static_cast<std::uint64_t>(device()) << 32) | device();
  return static_cast<std::int64_t>(bits >> 1) | 1;
}

void catch_signals() {
  struct sigaction action {};
  action.sa_handler = mark;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaction(signal, &action, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
}

bool interrupted() { return caught != 0; }

Terminal::Terminal(Style style) : style_(style) {
  if (style == Style::screen && !Screen::possible()) style_ = Style::plain;
  if (style_ == Style::screen) screen_ = std::make_unique<Screen>();
}

void Terminal::shot_result(const ShotResult& shot_result) {
  if (style_ == Style::json) {
    std::puts(shot_result_json(shot_result).c_str());
  } else if (style_ == Style::plain) {
    print(render_shot(shot_result, kPlainWidth));
  }
  std::fflush(stdout);
}

void Terminal::notify(const std::string& text) {
  if (!screen_) std::fprintf(stderr, "strobe: %s\n", text.c_str());
}

void Terminal::show(const Model& model, std::int64_t now_ns) {
  if (!screen_ || now_ns - painted_ns_ < kRepaint_ns) return;
  painted_ns_ = now_ns;
  screen_->paint(render(model, screen_->width()));
}

void print(const std::vector<std::string>& lines) {
  for (const std::string& line : lines) std::puts(line.c_str());
  std::fflush(stdout);
}

std::string shot_result_json(const ShotResult& shot_result) {
  if (shot_result.dry) return train_report_json(shot_result.train, shot_result.shot_id);
  return messages::readout_to_json(shot_result.readout);
}

std::string lcm_url(const std::string& given, const RigFile& rig) {
  if (!given.empty()) return given;
  return rig.lcm_url.value_or(messages::kDefaultLcmUrl);
}

}  // namespace strobe::host
