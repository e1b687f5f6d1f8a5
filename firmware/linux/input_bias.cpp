#include "firmware/linux/input_bias.hpp"

#include <cerrno>
#include <cstring>
#include <ctime>

#include "firmware/linux/rig_lines.hpp"

namespace strobe::firmware {

namespace {

using Verdict = CheckItem::Verdict;

constexpr int kNotSupported = 524;  // ENOTSUPP, the kernel's own, which some drivers let out

bool refuses_bias(int error) { return error == EINVAL || error == EOPNOTSUPP || error == kNotSupported; }

std::string words_of(int error) {
  return error == kNotSupported ? std::string("not supported") : std::string(std::strerror(error));
}

std::optional<Bias> fail_safe_bias(const Rig& rig, Line which) {
  return firmware::fail_safe_bias(which, rig.line(which).active_low);
}

std::string needs_resistor(Bias safe) {
  return std::string("a broken wire stops the rig only where a resistor on the line pulls it ") +
         (safe == Bias::pull_up ? "up" : "down");
}

std::string quoted(Bias bias) { return "\"" + std::string(name(bias)) + "\""; }

std::string cannot_set(Bias bias, int error) {
  return "the chip cannot set bias = " + quoted(bias) + " (" + words_of(error) + ")";
}

bool refuses(GpioChip& chip, InputLineSpec spec, int& error) {
  const auto with = chip.request_inputs(std::span(&spec, 1));
  if (with || !refuses_bias(with.error().error)) return false;
  error = with.error().error;
  spec.bias = Bias::as_is;
  return chip.request_inputs(std::span(&spec, 1)).has_value();
}

/// Does without each bias that the chip refuses.
Result<void> drop_refused(GpioChip& chip, const Rig& rig, std::span<const Line> lines,
                          std::vector<InputLineSpec>& specs, std::vector<std::string>& warnings) {
  for (std::size_t i = 0; i < specs.size(); ++i) {
    int error = 0;
    if (specs[i].bias == Bias::as_is || !refuses(chip, specs[i], error)) continue;
    const std::string what = cannot_set(specs[i].bias, error);
    const auto safe = fail_safe_bias(rig, lines[i]);
    if (rig.line(lines[i]).bias_chosen)
      return line_failure(rig, lines[i], what + ": with a resistor on the line, write bias = \"as_is\"");
    if (safe) warnings.push_back(line_message(rig, lines[i], what + ": " + needs_resistor(*safe)));
    specs[i].bias = Bias::as_is;
  }
  return {};
}

void warn(const GpioChip& chip, const Rig& rig, Line which, const InputLineSpec& spec,
          std::vector<std::string>& warnings) {
  const auto safe = fail_safe_bias(rig, which);
  const auto say = [&](const std::string& what) { warnings.push_back(line_message(rig, which, what)); };
  if (safe && !pulls(rig.line(which).bias))
    say("bias = " + quoted(rig.line(which).bias) + ": " + needs_resistor(*safe));
  if (spec.bias == Bias::as_is) return;
  const Bias told = chip.bias_of(spec.offset);
  if (told != spec.bias)
    say("bias = " + quoted(spec.bias) + " was asked for, and the kernel tells " + quoted(told));
}

struct Trial {
  int error = 0;  ///< as errno; 0: taken
  bool active = false;
  Bias told = Bias::as_is;  ///< by the kernel
};

Trial try_one(GpioChip& chip, const InputLineSpec& spec) {
  auto request = chip.request_inputs(std::span(&spec, 1));
  if (!request) return {request.error().error, false, Bias::as_is};
  // Three time constants of a chip's weakest resistor, 100 kOhm, and 50 m of cable, 5 nF: 1.5 ms.
  const timespec settled{0, 2'000'000};
  clock_nanosleep(CLOCK_MONOTONIC, 0, &settled, nullptr);
  const auto level = request->level(0);
  return {level ? 0 : errno, level.value_or(false), chip.bias_of(spec.offset)};
}

/// What two trials of key or e-stop tell: under the wrong pull, then under the safe one.
CheckItem judge(const std::string& item, Bias safe, const Trial& wrong, const Trial& right,
                bool open_is_active) {
  const std::string set(name(safe));
  if (wrong.error == 0 && wrong.active != right.active)
    return {item, Verdict::ok, set + ", and the line follows it: its contact or its wire is open now"};
  if (right.active != open_is_active)
    return {item, Verdict::ok, set + " is set as far as the kernel tells; the closed contact holds the line"};
  return {item, Verdict::advice,
          set +
              " is set as far as the kernel tells, but the other pull does not move the line: a resistor or "
              "a contact "
              "holds it, or this chip has no resistors and Linux does not say so; then " +
              needs_resistor(safe)};
}

}  // namespace

Result<BiasedInputs> request_biased(GpioChip& chip, const Rig& rig, std::span<const Line> lines,
                                    std::vector<InputLineSpec> specs) {
  std::vector<std::string> warnings;
  auto taken = chip.request_inputs(specs);
  if (!taken && refuses_bias(taken.error().error)) {
    if (auto dropped = drop_refused(chip, rig, lines, specs, warnings); !dropped)
      return tl::unexpected(dropped.error());
    taken = chip.request_inputs(specs);
  }
  if (!taken) {
    const RequestFailure& failure = taken.error();
    return line_failure(rig, lines[failure.line],
                        request_error(chip, specs[failure.line].offset, failure.error));
  }
  for (std::size_t i = 0; i < specs.size(); ++i) warn(chip, rig, lines[i], specs[i], warnings);
  return BiasedInputs{std::move(*taken), std::move(warnings)};
}

std::vector<CheckItem> try_bias(GpioChip& chip, const Rig& rig, Line which, unsigned offset) {
  const LineConfig& config = rig.line(which);
  const auto safe = fail_safe_bias(rig, which);
  const std::string item = std::string("lines.") + line_key(which) + ".bias";
  if (safe && !pulls(config.bias))
    return {{item, Verdict::advice, quoted(config.bias) + ": " + needs_resistor(*safe)}};
  if (config.bias == Bias::as_is) return {};
  InputLineSpec spec{offset, config.active_low, true, config.bias};
  Trial wrong;
  if (safe) {
    spec.bias = opposite(*safe);
    wrong = try_one(chip, spec);
    spec.bias = config.bias;
  }
  const Trial right = try_one(chip, spec);
  if (refuses_bias(right.error)) {
    const std::string what = cannot_set(config.bias, right.error);
    if (config.bias_chosen)
      return {{item, Verdict::fault, what + ": with a resistor on the line, write \"as_is\""}};
    return {{item, Verdict::advice, safe ? what + ": " + needs_resistor(*safe) : what}};
  }
  if (right.error != 0) return {{item, Verdict::fault, request_error(chip, offset, right.error)}};
  if (right.told != config.bias)
    return {{item, Verdict::advice,
             quoted(config.bias) + " was asked for, and the kernel tells " + quoted(right.told)}};
  if (!safe)
    return {{item, Verdict::ok, std::string(name(config.bias)) + " is set as far as the kernel tells"}};
  return {judge(item, *safe, wrong, right, which == Line::estop)};
}

}  // namespace strobe::firmware
