#include "firmware/linux/preemption.hpp"

#include <array>
#include <optional>
#include <sstream>
#include <utility>

namespace strobe::firmware {

namespace {

std::optional<Preemption> by_name(const std::string& name) {
  if (name == "none") return Preemption::none;
  if (name == "voluntary") return Preemption::voluntary;
  if (name == "full" || name == "lazy") return Preemption::full;
  return std::nullopt;
}

bool has_word(const std::string& text, const std::string& word) {
  std::istringstream words(text);
  for (std::string each; words >> each;) {
    if (each == word) return true;
  }
  return false;
}

/// "none (voluntary) full": the one in brackets rules.
std::optional<Preemption> in_brackets(const std::string& models) {
  const std::size_t open = models.find('(');
  const std::size_t close = models.find(')', open);
  if (open == std::string::npos || close == std::string::npos) return std::nullopt;
  return by_name(models.substr(open + 1, close - open - 1));
}

/// Of several the last one counts.
std::optional<Preemption> on_command_line(const std::string& line) {
  const std::string key = "preempt=";
  std::optional<Preemption> chosen;
  std::istringstream words(line);
  for (std::string word; words >> word;) {
    if (word.compare(0, key.size(), key) != 0) continue;
    if (const auto model = by_name(word.substr(key.size()))) chosen = model;
  }
  return chosen;
}

std::optional<Preemption> in_configuration(const std::string& text) {
  constexpr std::array<std::pair<const char*, Preemption>, 4> kChoices{
      {{"CONFIG_PREEMPT_NONE=y", Preemption::none},
       {"CONFIG_PREEMPT_VOLUNTARY=y", Preemption::voluntary},
       {"CONFIG_PREEMPT=y", Preemption::full},
       {"CONFIG_PREEMPT_LAZY=y", Preemption::full}}};
  for (const auto& [option, model] : kChoices) {
    if (has_word(text, option)) return model;
  }
  return std::nullopt;
}

}  // namespace

PreemptionModel read_preemption(const SystemFiles& files) {
  const std::string realtime = "sys/kernel/realtime";
  const std::string version = "proc/sys/kernel/version";
  const std::string flags = files.read(version).value_or("");
  if (files.read(realtime) == "1") return {Preemption::real_time, "/" + realtime, false};
  if (has_word(flags, "PREEMPT_RT")) return {Preemption::real_time, "/" + version, false};

  const std::string configuration = "boot/config-" + files.read("proc/sys/kernel/osrelease").value_or("");
  const bool dynamic = has_word(flags, "PREEMPT_DYNAMIC");
  if (dynamic) {
    const std::string debug = "sys/kernel/debug/sched/preempt";
    if (const auto model = in_brackets(files.read(debug).value_or(""))) return {*model, "/" + debug, true};
    const std::string line = "proc/cmdline";
    if (const auto model = on_command_line(files.read(line).value_or(""))) return {*model, "/" + line, true};
  } else if (has_word(flags, "PREEMPT")) {
    return {Preemption::full, "/" + version, false};
  }
  if (const auto model = in_configuration(files.read(configuration).value_or("")))
    return {*model, "/" + configuration, dynamic};
  return {Preemption::unknown, flags.empty() ? "" : "/" + version, dynamic};
}

}  // namespace strobe::firmware
