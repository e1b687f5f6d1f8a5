#include "firmware/linux/interrupts.hpp"

#include "tests/firmware/system_tree.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe::firmware;

TEST_GROUP(Interrupts) {
  strobe::testing::SystemTree tree;
  SystemFiles files = tree.files();
};

TEST(Interrupts, AreReadWithTheirDevicesAndCpus) {
  tree.put("proc/irq/default_smp_affinity", "3");
  tree.fixed_interrupt(36, "virtio1-req.0", "0-1");
  const auto all = read_interrupts(files);
  CHECK_EQUAL(2U, all.size());
  CHECK_EQUAL(24, all[0].number);
  CHECK_EQUAL(std::string("ttyS0"), all[0].name);
  CHECK_TRUE(all[0].movable);
  CHECK_EQUAL(std::string("virtio1-req.0"), all[1].name);
  CHECK_EQUAL((std::set<int>{0, 1}), all[1].cpus);
  CHECK_FALSE(all[1].movable);
}

TEST(Interrupts, AreNamedByTheKernelsListOfUsersIfThereIsOne) {
  tree.put("sys/kernel/irq/24/actions", "serial,modem");
  CHECK_EQUAL(std::string("serial,modem"), read_interrupts(files)[0].name);
}

TEST(Interrupts, AreKeptOffACpuAndStayWhereElseTheyMayRun) {
  tree.interrupt(25, "net", "0-1");
  tree.interrupt(26, "usb", "1");
  const InterruptMoves moved = move_interrupts_off(1, files);
  CHECK_EQUAL(2U, moved.away.size());
  CHECK_TRUE(moved.refused.empty());
  CHECK_EQUAL(std::string("0"), files.read("proc/irq/25/smp_affinity_list").value());
  CHECK_EQUAL(std::string("0"), files.read("proc/irq/26/smp_affinity_list").value());
  CHECK_EQUAL(std::string("0"), files.read("proc/irq/24/smp_affinity_list").value());
}

TEST(Interrupts, ThatCannotBeMovedAreLeftAndNamed) {
  tree.fixed_interrupt(36, "virtio1-req.0", "0-1");
  const InterruptMoves moved = move_interrupts_off(1, files);
  CHECK_EQUAL(1U, moved.fixed.size());
  CHECK_EQUAL(36, moved.fixed[0].number);
  CHECK_EQUAL(std::string("0-1"), files.read("proc/irq/36/smp_affinity_list").value());
}

TEST(Interrupts, ThatAreRequestedLaterAreKeptOffTheCpuToo) {
  tree.put("proc/irq/default_smp_affinity", "3");
  CHECK_TRUE(newcomers_may_run_on(1, files));
  CHECK_TRUE(move_interrupts_off(1, files).newcomers_kept_off);
  CHECK_EQUAL(std::string("1"), files.read("proc/irq/default_smp_affinity").value());
  CHECK_TRUE(move_interrupts_off(1, files).newcomers_kept_off);
}

TEST(Interrupts, ThatAreRequestedLaterStayWhereThereIsNoOtherCpu) {
  tree.put("proc/irq/default_smp_affinity", "2");
  CHECK_FALSE(move_interrupts_off(1, files).newcomers_kept_off);
  CHECK_EQUAL(std::string("2"), files.read("proc/irq/default_smp_affinity").value());
}

TEST(Interrupts, OfTheOnlyCpuAreRefused) {
  tree.put("sys/devices/system/cpu/online", "0");
  CHECK_EQUAL(1U, move_interrupts_off(0, files).refused.size());
}
