#include "tests/sim/gpiochip/fixture.hpp"

#include <sys/stat.h>
#include <time.h>

#include <stdexcept>
#include <utility>

namespace strobe::sim {

MonoTime now() { return from_ns(testing::monotonic_now_ns()); }

std::filesystem::path built_program(const std::string& name) {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path() / name;
}

ChipFixture::ChipFixture(const ChipSpec& spec) : chip_folder_(logs_ / "chip") {
  chmod(logs_.path().c_str(), 0755);  // for programs that become another user
  auto created = Chip::create(chip_folder_, spec);
  if (!created) throw std::runtime_error(created.error().message);
  chip_ = std::make_unique<Chip>(std::move(*created));
  cursor_ = chip_->cursor_now();
}

testing::Command ChipFixture::preloaded(std::vector<std::string> arguments, const std::string& first) const {
  const auto library = preload_path();
  if (!library) throw std::runtime_error(library.error().message);
  testing::Command command;
  command.arguments = std::move(arguments);
  command.environment = {{kChipDirVariable, chip_folder_.string()},
                         {"LD_PRELOAD", first.empty() ? library->string() : first + ":" + library->string()}};
  return command;
}

testing::Process ChipFixture::actor(std::vector<std::string> role, const std::string& until,
                                    const std::string& program) const {
  role.insert(role.begin(), built_program(program).string());
  testing::Process process(preloaded(std::move(role)), logs_.path());
  if (!process.wait_for_out(until, kLimit))
    throw std::runtime_error("the actor did not start: " + process.out() + process.err());
  return process;
}

testing::CompletedProcess ChipFixture::run(std::vector<std::string> arguments) const {
  return testing::run_process(preloaded(std::move(arguments)), kLimit);
}

std::vector<Change> ChipFixture::changes(std::size_t count) {
  std::vector<Change> found;
  const MonoTime limit = now() + milliseconds(kLimit.count());
  while (found.size() < count && now() < limit)
    if (!chip_->wait_changes(cursor_, limit, found)) throw std::runtime_error("the ring lapped the test");
  return found;
}

std::vector<int> ChipFixture::levels(const std::vector<Change>& changes, std::uint32_t line) {
  std::vector<int> found;
  for (const Change& change : changes)
    if (change.line == line) found.push_back(change.level);
  return found;
}

}  // namespace strobe::sim
