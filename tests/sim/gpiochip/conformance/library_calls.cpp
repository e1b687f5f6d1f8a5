// library_calls CHIP A B C ANSWERS: libgpiod as the firmware uses it, answer by answer.
//
// Every call of libgpiod that the firmware makes, the errors that it relies on, and how a chip goes away
// under it, printed line by line: on the simulated chip and on a real kernel's, whose answers are compared
// with the same expected file. A and B are offsets of free lines to which nothing is connected, C of one that
// the outside drives, low at first. Where something must happen outside, a line "please: ..." says what;
// whoever did it opens the FIFO ANSWERS and closes it again.
#include <errno.h>
#include <fcntl.h>
#include <gpiod.h>
#include <poll.h>
#include <signal.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace {

constexpr const char* kConsumer = "conform";
constexpr int kLowFlag = GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW;

gpiod_chip* chip = nullptr;
unsigned line_a = 0, line_b = 0, line_c = 0;
const char* answers = nullptr;

void say(const char* what, const std::string& answer) { std::printf("%s: %s\n", what, answer.c_str()); }
/// libgpiod's outcome: -1 with errno, or a number.
void say_outcome(const char* what, int result) { say(what, result < 0 ? strerrorname_np(errno) : "ok"); }
void say_value(const char* what, int result) {
  say(what, result < 0 ? strerrorname_np(errno) : std::to_string(result));
}
void say_found(const char* what, const void* found) { say(what, found ? "found" : strerrorname_np(errno)); }
const char* text_or_none(const char* text) { return text != nullptr ? text : "none"; }

void please(const char* what) {
  std::printf("please: %s\n", what);
  const int fifo = open(answers, O_RDONLY);  // once somebody has it open for writing
  char rest[64];
  while (fifo >= 0 && read(fifo, rest, sizeof rest) > 0) continue;
  if (fifo < 0) std::exit(1);
  close(fifo);
}

gpiod_line* line(unsigned offset) { return gpiod_chip_get_line(chip, offset); }

std::int64_t now_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * 1'000'000'000LL + now.tv_nsec;
}
std::int64_t ns_of(const timespec& stamp) { return stamp.tv_sec * 1'000'000'000LL + stamp.tv_nsec; }

void opening(const char* name) {
  for (const char* wrong : {"gpiochip77", "/dev/gpiochip77", "no such label"}) {
    gpiod_chip* found = gpiod_chip_open_lookup(wrong);
    say_found(wrong, found);
  }
  const std::string path = std::string("/dev/") + name;
  gpiod_chip* by_path = gpiod_chip_open_lookup(path.c_str());
  say_found("by its path", by_path);
  const std::string label = by_path != nullptr ? gpiod_chip_label(by_path) : "";
  gpiod_chip* by_label = gpiod_chip_open_lookup(label.c_str());
  say_found("by its label", by_label);
  if (by_label != nullptr) gpiod_chip_close(by_label);
  if (by_path != nullptr) gpiod_chip_close(by_path);
  chip = gpiod_chip_open_lookup(name);
  say_found("by its name", chip);
  if (chip == nullptr) std::exit(1);
  say("its name", std::string(gpiod_chip_name(chip)) == name ? "as asked for" : "another");
  say("it has those lines", gpiod_chip_num_lines(chip) > line_c ? "yes" : "no");
}

void finding() {
  say_found("line by offset", line(line_a));
  say_value("whose offset is as asked", gpiod_line_offset(line(line_a)) == line_a ? 1 : 0);
  say_found("line past the last", gpiod_chip_get_line(chip, 1000));
  say_found("line by a name that none has", gpiod_chip_find_line(chip, "NO_SUCH_LINE"));
  say_value("free line is used", gpiod_line_is_used(line(line_a)) ? 1 : 0);
  say("its consumer", text_or_none(gpiod_line_consumer(line(line_a))));
  say_outcome("look again", gpiod_line_update(line(line_a)));
}

void outputs() {
  gpiod_line_bulk pair = GPIOD_LINE_BULK_INITIALIZER;
  gpiod_line_bulk_add(&pair, line(line_a));
  gpiod_line_bulk_add(&pair, line(line_b));
  const std::array<int, 2> off{0, 0}, on{1, 1}, one{1, 0};
  say_outcome("two outputs", gpiod_line_request_bulk_output(&pair, kConsumer, off.data()));
  say_value("the first of them", gpiod_line_bulk_get_line(&pair, 0) == line(line_a) ? 1 : 0);
  say_value("line is used", gpiod_line_is_used(line(line_a)) ? 1 : 0);
  say_outcome("look again", gpiod_line_update(line(line_a)));
  say("its consumer", text_or_none(gpiod_line_consumer(line(line_a))));
  say_outcome("both on", gpiod_line_set_value_bulk(&pair, on.data()));
  say_value("first", gpiod_line_get_value(line(line_a)));
  say_value("second", gpiod_line_get_value(line(line_b)));
  say_outcome("one on", gpiod_line_set_value_bulk(&pair, one.data()));
  say_value("first", gpiod_line_get_value(line(line_a)));
  say_value("second", gpiod_line_get_value(line(line_b)));
  say_outcome("request again by the same", gpiod_line_request_output(line(line_a), kConsumer, 0));

  gpiod_chip* other = gpiod_chip_open_lookup(gpiod_chip_name(chip));
  gpiod_line* same = gpiod_chip_get_line(other, line_a);
  say_value("another sees it used", gpiod_line_is_used(same) ? 1 : 0);
  say("by", text_or_none(gpiod_line_consumer(same)));
  say_outcome("another requests it", gpiod_line_request_output(same, kConsumer, 0));
  const gpiod_line_request_config edges{kConsumer, GPIOD_LINE_REQUEST_EVENT_BOTH_EDGES, 0};
  say_outcome("another requests its edges", gpiod_line_request(same, &edges, 0));
  say_outcome("set by who does not have it", gpiod_line_set_value(same, 0));
  gpiod_line_release_bulk(&pair);
  say_outcome("once released", gpiod_line_request_output(same, kConsumer, 1));
  say_value("it is", gpiod_line_get_value(same));
  gpiod_chip_close(other);
  say_outcome("once the chip was closed", gpiod_line_request_output(line(line_a), kConsumer, 0));
  gpiod_line_release(line(line_a));
}

void output_of_a_killed_owner() {
  int pipes[2];
  if (pipe(pipes) != 0) std::exit(1);
  const pid_t child = fork();
  if (child == 0) {
    gpiod_chip* own = gpiod_chip_open_lookup(gpiod_chip_name(chip));
    const int taken = gpiod_line_request_output(gpiod_chip_get_line(own, line_a), "victim", 1);
    if (write(pipes[1], &taken, sizeof taken) == sizeof taken) pause();
    _exit(0);
  }
  int taken = -1;
  if (read(pipes[0], &taken, sizeof taken) != sizeof taken) std::exit(1);
  say_outcome("taken by another process", taken);
  say_outcome("request meanwhile", gpiod_line_request_output(line(line_a), kConsumer, 0));
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  say_outcome("once it was killed", gpiod_line_request_output(line(line_a), kConsumer, 0));
  say_value("driven inactive", gpiod_line_get_value(line(line_a)));
  gpiod_line_release(line(line_a));
}

void say_events(const char* what, gpiod_line* from, std::int64_t since_ns) {
  std::array<gpiod_line_event, 16> events{};
  const int count = gpiod_line_event_read_fd_multiple(gpiod_line_event_get_fd(from), events.data(),
                                                      static_cast<unsigned>(events.size()));
  if (count < 0) {
    say_value(what, count);
    return;
  }
  std::string kinds;
  std::int64_t last = since_ns;
  bool in_order = true;
  for (int i = 0; i < count; ++i) {
    const gpiod_line_event& event = events[static_cast<std::size_t>(i)];
    kinds += event.event_type == GPIOD_LINE_EVENT_RISING_EDGE ? " rising" : " falling";
    in_order = in_order && ns_of(event.ts) >= last && ns_of(event.ts) <= now_ns();
    last = ns_of(event.ts);
  }
  say(what, std::to_string(count) + kinds + (in_order ? ", stamped in order" : ", STAMPED OUT OF ORDER"));
}

std::string polled(gpiod_line* of, int patience_ms) {
  pollfd waiting{gpiod_line_event_get_fd(of), POLLIN, 0};
  const int ready = poll(&waiting, 1, patience_ms);
  if (ready <= 0) return "nothing";
  // A hang-up comes with an error from some kernels, and without from others.
  return (waiting.revents & (POLLHUP | POLLERR)) != 0 ? "hang-up" : "events";
}

void edges() {
  gpiod_line* const c = line(line_c);
  const gpiod_line_request_config rising{kConsumer, GPIOD_LINE_REQUEST_EVENT_RISING_EDGE, 0};
  say_outcome("rising edges", gpiod_line_request(c, &rising, 0));
  std::int64_t since = now_ns();
  say_value("level", gpiod_line_get_value(c));
  say("poll", polled(c, 0));
  please("C 1 0 1");
  say("poll", polled(c, 1000));
  say_events("events", c, since);
  say_value("level", gpiod_line_get_value(c));
  gpiod_line_release(c);

  const gpiod_line_request_config both{kConsumer, GPIOD_LINE_REQUEST_EVENT_BOTH_EDGES, kLowFlag};
  say_outcome("both edges, active low", gpiod_line_request(c, &both, 0));
  since = now_ns();
  say_value("level", gpiod_line_get_value(c));
  please("C 0 1");
  say("poll", polled(c, 1000));
  say_events("events", c, since);
  please("C 0 1 0 1 0 1 0 1 0 1 0 1 0 1 0 1 0 1 0 1");
  say("poll", polled(c, 1000));
  say_events("of 20 events the oldest", c, since);
  say("poll", polled(c, 0));
  gpiod_line_release(c);
}

void gone() {
  gpiod_line_bulk pair = GPIOD_LINE_BULK_INITIALIZER;
  gpiod_line_bulk_add(&pair, line(line_a));
  gpiod_line_bulk_add(&pair, line(line_b));
  const std::array<int, 2> off{0, 0}, on{1, 1};
  gpiod_line* const c = line(line_c);
  const gpiod_line_request_config both{kConsumer, GPIOD_LINE_REQUEST_EVENT_BOTH_EDGES, 0};
  gpiod_chip* spare = gpiod_chip_open_lookup(gpiod_chip_name(chip));
  const std::string name = gpiod_chip_name(chip);
  say_outcome("two outputs", gpiod_line_request_bulk_output(&pair, kConsumer, off.data()));
  say_outcome("both edges", gpiod_line_request(c, &both, 0));
  please("unplug");
  say_outcome("set", gpiod_line_set_value_bulk(&pair, on.data()));
  say_value("level", gpiod_line_get_value(c));
  say("poll", polled(c, 1000));
  std::array<gpiod_line_event, 16> events{};
  fcntl(gpiod_line_event_get_fd(c), F_SETFL, O_NONBLOCK);
  say_value("events", gpiod_line_event_read_fd_multiple(gpiod_line_event_get_fd(c), events.data(), 16));
  gpiod_line* const free_line = gpiod_chip_get_line(spare, line_a);
  say_found("line of a chip opened before", free_line);
  say_found("open", gpiod_chip_open_lookup(name.c_str()));
  gpiod_line_release_bulk(&pair);
  gpiod_line_release(c);
  say("after letting go", "alive");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 6) {
    std::fprintf(stderr, "usage: library_calls CHIP LINE_A LINE_B LINE_C ANSWERS\n");
    return 2;
  }
  line_a = static_cast<unsigned>(std::atoi(argv[2]));
  line_b = static_cast<unsigned>(std::atoi(argv[3]));
  line_c = static_cast<unsigned>(std::atoi(argv[4]));
  answers = argv[5];
  std::setvbuf(stdout, nullptr, _IONBF, 0);  // a forked child has nothing left to print
  opening(argv[1]);
  finding();
  outputs();
  output_of_a_killed_owner();
  edges();
  gone();
}
