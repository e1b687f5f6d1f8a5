// strobed as a service of the emulated machine's systemd: its state by the machine's shell, its shots by the lines.
// As KernelFixture's, from one thread.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tests/kernel/kernel_fixture.hpp"

namespace strobe::kernel {

inline constexpr int kFlashes = 20;    ///< of rig.toml's plan: 2600 ms, one each 130 ms
inline constexpr int kLongTrain = 75;  ///< 9.75 s, likewise

class Service {
 public:
  /// As KernelFixture.
  explicit Service(const std::filesystem::path& boot, const KernelFixture::Install& install = {})
      : bench_(boot, install) {}

  KernelFixture& bench() { return bench_; }

  std::string shell(const std::string& line) { return bench_.machine().run(line); }
  std::string word(const std::string& line);  ///< without the end of its only line
  std::string property(const std::string& name) { return word("systemctl show -P " + name + " strobed"); }
  std::string journal() { return shell("journalctl -b -u strobed -o cat --no-pager | tail -n 60"); }
  bool becomes(const std::string& state);

  /// From here on flashes are counted.
  void count_from_now() { before_ = bench_.events().size(); }
  std::vector<int> flashes_of_each_shot() const;

  /// By `strobe fire` outside, which may flag it. A machine that stands still for long aborts one: then the next.
  testing::CompletedProcess fire_a_shot();
  /// A train of kLongTrain flashes, under way. Returns null if none of some is.
  std::unique_ptr<testing::Process> fire_and_wait_for_the_train();

 private:
  KernelFixture bench_;
  std::size_t before_ = 0;
};

}  // namespace strobe::kernel
