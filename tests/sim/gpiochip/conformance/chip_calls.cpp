// gpio_chip_calls CHIP LABEL A B C ANSWERS: the firmware's own GpioChip, answer by answer.
//
// Requests, levels, edges, the errors that the firmware relies on, and how a chip goes away under it, printed line by
// line: on the simulated chip and on a real kernel's, with either libgpiod, all compared with the same expected file.
// A and B are offsets of free lines to which nothing is connected, C of one that the outside drives, low at first.
// Where something must happen outside, a line "please: ..." says what; whoever did it opens the FIFO ANSWERS and closes
// it again.
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "firmware/gpio/gpio_chip.hpp"
#include "tests/sim/gpiochip/conformance/answers.hpp"

namespace {

using namespace strobe;
using namespace strobe::firmware;

const char *chip_name = nullptr, *label = nullptr;
unsigned line_a = 0, line_b = 0, line_c = 0;
const char* answers_path = nullptr;

using answers::say;
void say(const char* what, bool answer) { say(what, std::string(answer ? "yes" : "no")); }
template <typename Request>
void say_outcome(const char* what, const tl::expected<Request, RequestFailure>& request) {
  say(what,
      request ? "ok"
              : strerrorname_np(request.error().error) + (", line " + std::to_string(request.error().line)));
}
void say_level(const char* what, const std::optional<bool>& level) {
  say(what, std::string(!level ? "cannot be read" : (*level ? "active" : "inactive")));
}
void say_user(const char* what, const std::optional<std::string>& user) {
  say(what, user ? "\"" + *user + "\"" : "none");
}

void please(const char* what) { answers::please(answers_path, what); }

MonoTime now() {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return from_ns(time.tv_sec * 1'000'000'000LL + time.tv_nsec);
}

GpioChip opened() {
  auto chip = GpioChip::open(chip_name);
  if (!chip) std::exit(1);
  return std::move(*chip);
}

const std::array<unsigned, 2>& pair() {
  static const std::array<unsigned, 2> offsets{line_a, line_b};
  return offsets;
}
std::span<const unsigned> first() { return std::span(pair()).first(1); }

void say_opening(const char* which) {
  const auto chip = GpioChip::open(which);
  say(which, std::string(chip ? "opened" : strerrorname_np(chip.error())));
}

void opening() {
  for (const char* wrong : {"gpiochip77", "77", "/dev/gpiochip77", "no such label"}) say_opening(wrong);
  say("a device that is no chip", GpioChip::open("/dev/null").has_value());
  say("by its path", GpioChip::open(std::string("/dev/") + chip_name).has_value());
  say("by its number", GpioChip::open(std::string(chip_name).substr(8)).has_value());
  say("by its label", GpioChip::open(label).has_value());
  const GpioChip chip = opened();
  say("its name is as asked for", chip.name() == chip_name);
  say("it has those lines", chip.line_count() > line_c);
  say("line by a name that none has", chip.find_line("NO_SUCH_LINE").has_value());
  say_user("user of a free line", chip.user_of(line_a));
  say_user("user of a line past the last", chip.user_of(1000));
}

void outputs() {
  GpioChip chip = opened();
  auto two = chip.request_outputs(pair());
  say_outcome("two outputs", two);
  if (!two) std::exit(1);
  say_user("user of the first", chip.user_of(line_a));
  say("both active", two->set(std::array{true, true}));
  say("one active", two->set(std::array{true, false}));
  say("taken back", two->take_back());
  say("one active once more", two->set(std::array{true, false}));
  say_outcome("request again by the same", chip.request_outputs(first()));
  const unsigned past = 1000;
  say_outcome("of a line past the last", chip.request_outputs(std::span(&past, 1)));
  GpioChip other = opened();
  say_user("another sees it used by", other.user_of(line_a));
  say_outcome("another requests it", other.request_outputs(first()));
  const InputLineSpec edges{line_b, false, true};
  say_outcome("another requests its edges", other.request_inputs(std::span(&edges, 1)));
  { const OutputRequest released = std::move(*two); }
  say_outcome("once released", other.request_outputs(first()));
  say_user("once that was released too", other.user_of(line_a));
}

void output_of_a_killed_owner() {
  GpioChip chip = opened();
  int pipes[2];
  if (pipe(pipes) != 0) std::exit(1);
  const pid_t child = fork();
  if (child == 0) {
    GpioChip own = opened();
    auto taken = own.request_outputs(first());
    const bool active = taken && taken->set(std::array{true});
    if (write(pipes[1], &active, sizeof active) == sizeof active) pause();
    _exit(0);
  }
  bool taken = false;
  if (read(pipes[0], &taken, sizeof taken) != sizeof taken) std::exit(1);
  say("taken by another process", taken);
  say_outcome("request meanwhile", chip.request_outputs(first()));
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  say_outcome("once it was killed", chip.request_outputs(first()));
}

std::string polled(const InputRequest& request, int patience_ms) {
  pollfd waiting{request.descriptors().front(), POLLIN, 0};
  const int ready = poll(&waiting, 1, patience_ms);
  if (ready <= 0) return "nothing";
  // A hang-up comes with an error from some kernels, and without from others.
  return (waiting.revents & (POLLHUP | POLLERR)) != 0 ? "hang-up" : "edges";
}

void say_edges(const char* what, InputRequest& request, MonoTime since) {
  std::array<LineEdge, 64> edges;
  const auto count = request.read(0, edges);
  if (!count) return say(what, std::string("cannot be read"));
  std::string kinds = std::to_string(*count);
  bool in_order = true;
  for (std::size_t i = 0; i < *count; ++i) {
    kinds += edges[i].active ? " active" : " inactive";
    in_order = in_order && edges[i].line == 0 && edges[i].time >= since && edges[i].time <= now();
    since = edges[i].time;
  }
  say(what, kinds + (in_order ? ", stamped in order" : ", STAMPED OUT OF ORDER"));
}

void edges() {
  GpioChip chip = opened();
  {
    const InputLineSpec to_active{line_c, false, false};
    auto input = chip.request_inputs(std::span(&to_active, 1));
    say_outcome("edges to active", input);
    if (!input) std::exit(1);
    const MonoTime since = now();
    say_level("level", input->level(0));
    say("poll", polled(*input, 0));
    please("C 1 0 1");
    say("poll", polled(*input, 1000));
    say_edges("edges", *input, since);
    say_level("level", input->level(0));
  }
  const InputLineSpec both{line_c, true, true};
  auto input = chip.request_inputs(std::span(&both, 1));
  say_outcome("both edges, active low", input);
  if (!input) std::exit(1);
  const MonoTime since = now();
  say_level("level", input->level(0));
  please("C 0 1");
  say("poll", polled(*input, 1000));
  say_edges("edges", *input, since);
  say("an overflow", input->overflows() > 0);
  please("C 0 1 0 1 0 1 0 1 0 1 0 1 0 1 0 1 0 1 0 1");
  std::array<LineEdge, 64> many;
  const auto count = input->read(0, many);
  say("of 20 edges all came, or an overflow is told", count && (*count == 20 || input->overflows() > 0));
  say("poll", polled(*input, 0));
}

/// While nobody reads, more edges than any kernel's buffer holds, though a slow one may see one in two.
void flood() {
  GpioChip chip = opened();
  const std::array<InputLineSpec, 2> specs{{{line_b, false, true}, {line_c, false, true}}};
  auto input = chip.request_inputs(specs);
  say_outcome("both edges of two lines", input);
  if (!input) std::exit(1);
  please("C 0 1 x 1500");
  std::array<LineEdge, 64> some;
  bool well = true;
  std::size_t came = 0;
  pollfd waiting{input->descriptors().back(), POLLIN, 0};
  while (well && poll(&waiting, 1, 0) > 0) {
    const auto count = input->read(input->descriptors().size() - 1, some);
    well = count.has_value();
    came += count.value_or(0);
  }
  say("of a flood of edges what the buffer holds came", well && came >= 16);
  say("an overflow is told", input->overflows() > 0);
  const std::int64_t lost = input->overflows();
  please("B 1 0");
  please("C 0 1");
  for (std::size_t i = 0; i < input->descriptors().size(); ++i) input->read(i, some);
  say("more are told of edges that are taken in time", input->overflows() > lost);
  say_level("level", input->level(1));
}

void gone() {
  GpioChip chip = opened();
  const GpioChip spare = opened();
  auto two = chip.request_outputs(pair());
  const InputLineSpec both{line_c, false, true};
  auto input = chip.request_inputs(std::span(&both, 1));
  say_outcome("two outputs", two);
  say_outcome("both edges", input);
  if (!two || !input) std::exit(1);
  please("unplug");
  say("set", two->set(std::array{true, true}));
  say_level("level", input->level(0));
  say("poll", polled(*input, 1000));
  say_edges("edges", *input, now());
  say_outcome("request", chip.request_outputs(first()));
  say_user("user of a line of a chip opened before", spare.user_of(line_a));
  say_opening(chip_name);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 7) {
    std::fprintf(stderr, "usage: gpio_chip_calls CHIP LABEL LINE_A LINE_B LINE_C ANSWERS\n");
    return 2;
  }
  chip_name = argv[1];
  label = argv[2];
  line_a = static_cast<unsigned>(std::atoi(argv[3]));
  line_b = static_cast<unsigned>(std::atoi(argv[4]));
  line_c = static_cast<unsigned>(std::atoi(argv[5]));
  answers_path = argv[6];
  std::setvbuf(stdout, nullptr, _IONBF, 0);  // a forked child has nothing left to print
  opening();
  outputs();
  output_of_a_killed_owner();
  edges();
  flood();
  gone();
  say("after letting go", std::string("alive"));
}
