#include "host/commands/terminal.hpp"

#include <fmt/format.h>
#include <ncurses.h>
#include <unistd.h>
#include <atomic>
#include <cerrno>
#include <clocale>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <nlohmann/json.hpp>
#include <random>

#include "common/messages/channels.hpp"
#include "common/messages/parsed_json.hpp"

namespace strobe::host {
namespace {

constexpr Duration kRepaint = milliseconds{100};

// Lock-free, as a handler needs it; several threads may be interrupted at once.
std::atomic<int> ends_asked{0};
static_assert(std::atomic<int>::is_always_lock_free);

void count(int signal) { ends_asked += signal == SIGQUIT ? 2 : 1; }

}  // namespace

std::int64_t random_host_id() {
  std::random_device device;
  const std::uint64_t bits = (static_cast<std::uint64_t>(device()) << 32) | device();
  return static_cast<std::int64_t>(bits >> 1) | 1;
}

void catch_signals() {
  struct sigaction action {};
  action.sa_handler = count;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) sigaction(signal, &action, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
}

int ends_asked_for() { return ends_asked; }

Terminal::Style Terminal::style(bool json, bool plain) {
  if (json) return Style::json;
  return plain ? Style::plain : Style::screen;
}

Terminal::Terminal(Style style, std::string title, int max_shots) : style_(style), max_shots_(max_shots) {
  model_.title = std::move(title);
}

void Terminal::open() {
  if (style_ == Style::screen && !Screen::possible()) style_ = Style::plain;
  if (style_ == Style::screen) screen_ = std::make_unique<Screen>();
}

void Terminal::on_shot_result(const Shot& result) {
  if (shown_ && !shown_(result.host_id)) return;
  model_.add(result);
  if (max_shots_ > 0 && model_.shots > max_shots_) return;
  if (style_ == Style::json) {
    std::puts(messages::json_text(shot_json(result)).c_str());
  } else if (style_ == Style::plain) {
    print(render_shot(result, kPlainWidth, model_.all));
  }
  if ((std::fflush(stdout) != 0 || std::ferror(stdout) != 0) && !output_problem_) {
    output_problem_ = std::string("standard output: cannot be written: ") + std::strerror(errno);
    on_notification(*output_problem_);
  }
}

void Terminal::on_notification(const std::string& text) {
  model_.add_notification(text);
  note(text);
}

void Terminal::note(const std::string& text) {
  if (!screen_) std::fprintf(stderr, "strobe: %s\n", text.c_str());
}

void Terminal::show(HostLoop& loop) {
  model_.verified = loop.verifies();
  model_.unverified = loop.unverified();
  if (const auto warning = model_.update(loop.session(), loop.now())) loop.notify(*warning);
  if (!screen_ || loop.now() - painted_ < kRepaint) return;
  painted_ = loop.now();
  if (screen_->paint(render(model_, screen_->width())) == 'a') model_.all = !model_.all;
}

void print(const std::vector<std::string>& lines) {
  for (const std::string& line : lines) std::puts(line.c_str());
  std::fflush(stdout);
}

std::string lcm_url(const std::string& given, const RigFile& rig) {
  if (!given.empty()) return given;
  return rig.lcm_url.value_or(messages::kDefaultLcmUrl);
}

bool Screen::possible() {
  const char* terminal = std::getenv("TERM");
  return ::isatty(STDOUT_FILENO) == 1 && terminal && *terminal && std::string(terminal) != "dumb";
}

Screen::Screen() {
  std::setlocale(LC_CTYPE, "");
  std::setlocale(LC_NUMERIC, "C");
  initscr();
  curs_set(0);
  leaveok(stdscr, TRUE);
}

Screen::~Screen() { endwin(); }

std::size_t Screen::width() const {
  return static_cast<std::size_t>(getmaxx(stdscr) > 0 ? getmaxx(stdscr) : 80);
}

int Screen::paint(const std::vector<std::string>& lines) {
  timeout(0);
  const int key = getch();  // takes note of a resized terminal, too
  erase();
  const int height = getmaxy(stdscr);
  for (int row = 0; row < height && row < static_cast<int>(lines.size()); ++row) {
    mvaddstr(row, 0, lines[static_cast<std::size_t>(row)].c_str());
  }
  refresh();
  return key;
}

}  // namespace strobe::host
