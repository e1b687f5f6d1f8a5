#include "host/commands/commission_console.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "common/messages/parsed_json.hpp"
#include "host/commission/record/record.hpp"

namespace strobe::host {
namespace {

using commission::Act;
using commission::Answer;
using commission::Commissioning;
using commission::Prompt;
using commission::StepResult;
using commission::StepState;
using commission::StepView;

void tell(const std::string& text) { std::fprintf(stderr, "%s\n", text.c_str()); }

const char* answers_of(const Prompt& prompt) {
  switch (prompt.kind) {
    case Prompt::Kind::begin:
      return prompt.moves ? "y: begin   s: leave it out   q: end" : "Enter: begin   s: leave it out   q: end";
    case Prompt::Kind::question:
      return "y or n";
    case Prompt::Kind::after_failure:
      return "Enter: again   n: go on   q: end";
  }
  return "";
}

}  // namespace

std::string result_line(const StepResult& result) {
  const std::string line =
      fmt::format("{:<8} {:<15} {}", commission::name(result.state), result.id, result.words);
  return result.advice.empty() ? line : fmt::format("{}\n{:25}{}", line, "", result.advice);
}

std::string result_json(const StepView& step) {
  commission::RecordedStep line;
  line.result = *step.result;
  line.title = step.info.title;
  auto object = messages::parsed_json<nlohmann::ordered_json>(commission::record_line(line));
  for (const char* const key : {"utc", "rig", "operator", "version", "tables_hash"}) object.erase(key);
  return messages::json_text(object);
}

void CommissionConsole::on_prompt(const StepView& step, const Prompt& prompt) {
  // What was typed before the question was there answers none.
  typed_.clear();
  ::tcflush(STDIN_FILENO, TCIFLUSH);
  if (prompt.kind == Prompt::Kind::begin) tell(fmt::format("\n{}: {}", step.info.id, step.info.title));
  tell("  " + prompt.words);
  tell(fmt::format("  [{}]", answers_of(prompt)));
}

void CommissionConsole::on_waiting(const StepView& step, const std::string& words, Act act) {
  tell(fmt::format("  {}: {}{}", step.info.id, words, act == Act::none ? "" : "   [Enter: a minute more]"));
}

void CommissionConsole::on_result(const StepView& step) {
  std::printf("%s\n", json_ ? result_json(step).c_str() : result_line(*step.result).c_str());
  std::fflush(stdout);
}

void CommissionConsole::read(Commissioning& commissioning) {
  pollfd input{STDIN_FILENO, POLLIN, 0};
  if (ended_ || ::poll(&input, 1, 0) <= 0) return;
  std::array<char, 256> bytes{};
  const ssize_t count = ::read(STDIN_FILENO, bytes.data(), bytes.size());
  if (count <= 0) {
    ended_ = true;
    if (commissioning.prompt()) commissioning.answer(Answer::end);
    return;
  }
  typed_.append(bytes.data(), static_cast<std::size_t>(count));
  for (std::size_t end = typed_.find('\n'); end != std::string::npos; end = typed_.find('\n')) {
    heed(typed_.substr(0, end), commissioning);
    typed_.erase(0, end + 1);
  }
}

void CommissionConsole::heed(const std::string& line, Commissioning& commissioning) {
  if (const auto& prompt = commissioning.prompt()) {
    if (const auto answer = commission::answer_of(*prompt, line)) return commissioning.answer(*answer);
    return tell(fmt::format("  [{}]", answers_of(*prompt)));
  }
  commissioning.stretch();
  tell("  a minute more");
}

}  // namespace strobe::host
