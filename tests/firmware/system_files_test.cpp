#include "firmware/linux/system_files.hpp"

#include "tests/firmware/system_tree.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe::firmware;

TEST_GROUP(SystemFiles) {
  strobe::testing::SystemTree tree;
  SystemFiles files = tree.files();
};

TEST(SystemFiles, ReadsAFileWithoutItsLineEnd) {
  CHECK_EQUAL(std::string("0-1"), files.read("sys/devices/system/cpu/online").value());
}

TEST(SystemFiles, WhatIsAbsentIsNothing) {
  CHECK_FALSE(files.read("proc/none").has_value());
  CHECK_TRUE(files.list("proc/none").empty());
  CHECK_FALSE(files.owner_may_write("proc/none"));
}

TEST(SystemFiles, ListsNumbersByTheirValue) {
  tree.interrupt(100, "a", "0");
  tree.interrupt(3, "b", "0");
  CHECK_EQUAL((std::vector<std::string>{"3", "24", "100"}), files.list("proc/irq"));
}

TEST(SystemFiles, ANumberIsDigitsOnly) {
  CHECK_TRUE(is_number("024"));
  for (const char* other : {"", "-1", "1-2", "gpiochip0", " 1"}) CHECK_FALSE(is_number(other));
}
TEST(SystemFiles, TellsWhatTheOwnerMayWriteEvenToRoot) {
  tree.fixed_interrupt(30, "disk", "0");
  CHECK_TRUE(files.owner_may_write("proc/irq/24/smp_affinity_list"));
  CHECK_FALSE(files.owner_may_write("proc/irq/30/smp_affinity_list"));
}

TEST(SystemFiles, WritesWhatCanBeReadBack) {
  CHECK_TRUE(files.write("proc/irq/24/smp_affinity_list", "1"));
  CHECK_EQUAL(std::string("1"), files.read("proc/irq/24/smp_affinity_list").value());
  CHECK_FALSE(files.write("proc/none/none", "1"));
}

TEST_GROUP(CpuList){};

TEST(CpuList, ReadsNumbersAndRanges) {
  CHECK_EQUAL((std::set<int>{0, 1, 2, 5}), parse_cpu_list("0-2,5\n"));
  CHECK(parse_cpu_list("").empty());
}

TEST(CpuList, LeavesOutWhatIsNotWellFormed) {
  CHECK_EQUAL(std::set<int>{3}, parse_cpu_list("x,3,-4,7-6"));
  CHECK_EQUAL(8193U, parse_cpu_list("0-999999999").size());
}

TEST(CpuList, WritesTheShortestList) {
  CHECK_EQUAL(std::string("0-2,5,7-8"), format_cpu_list({0, 1, 2, 5, 7, 8}));
  CHECK_EQUAL(std::string(), format_cpu_list({}));
}

TEST(SystemFiles, ReadsAndWritesMasksOfCpusAsTheKernel) {
  CHECK_TRUE((std::set<int>{0, 1, 32}) == parse_cpu_mask("1,00000003"));
  CHECK_TRUE((std::set<int>{4, 7}) == parse_cpu_mask("90"));
  CHECK_TRUE(parse_cpu_mask("no mask").empty());
  CHECK_EQUAL(std::string("1,00000003"), format_cpu_mask({0, 1, 32}));
  CHECK_EQUAL(std::string("1,00000000,00000000"), format_cpu_mask({64}));
  CHECK_EQUAL(std::string("0"), format_cpu_mask({}));
}
