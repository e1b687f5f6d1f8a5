#include <string>

#include "common/config/toml_reader.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe::config;

namespace {

constexpr const char* kText = R"(rig = "bench"
count = 3

[lamps]
pulse_us = 50      # integer where a number is asked for
delay_us = 12.5
on = true
train = "free"
steps = [1, 2.5]

[[fault]]
kind = "late"
[[fault]]
kind = "missing"
shot = 2
)";

std::string error_of(TomlReader& reader) {
  const auto error = reader.error();
  return error ? error->message : "";
}

/// Reads one number of an otherwise empty document.
std::string complaint(const std::string& value, Range range = {}) {
  TomlReader reader("a = 1\nx = " + value + "\n", "f.toml");
  reader.root().number("a");
  reader.root().number("x", range);
  return error_of(reader);
}

}  // namespace

TEST_GROUP(TomlReading){};

TEST(TomlReading, GivesWhatIsAskedForByNameAndType) {
  TomlReader reader(kText, "rig.toml");
  TomlTable root = reader.root();
  CHECK_EQUAL("bench", root.string("rig"));
  LONGS_EQUAL(3, root.integer("count"));
  TomlTable lamps = root.table("lamps");
  DOUBLES_EQUAL(50.0, lamps.number("pulse_us"), 0.0);
  DOUBLES_EQUAL(12.5, lamps.number_or("delay_us", 1.0), 0.0);
  CHECK_TRUE(lamps.boolean_or("on", false));
  CHECK_EQUAL("free", lamps.choice_or("train", "gated", {"free", "gated"}));
  const auto steps = lamps.numbers_or("steps", {});
  LONGS_EQUAL(2, steps.size());
  DOUBLES_EQUAL(2.5, steps[1], 0.0);
  auto faults = root.tables("fault");
  LONGS_EQUAL(2, faults.size());
  CHECK_EQUAL("late", faults[0].string("kind"));
  CHECK_EQUAL("missing", faults[1].string("kind"));
  LONGS_EQUAL(2, faults[1].integer_or("shot", 0));
  CHECK_EQUAL("", error_of(reader));
}

TEST(TomlReading, DefaultsStandInForWhatIsAbsent) {
  TomlReader reader("", "f.toml");
  TomlTable table = reader.root().table("nothing");
  CHECK_FALSE(table.present());
  DOUBLES_EQUAL(7.0, table.number_or("x", 7.0), 0.0);
  LONGS_EQUAL(8, table.integer_or("n", 8));
  CHECK_TRUE(table.boolean_or("b", true));
  CHECK_EQUAL("word", table.string_or("s", "word"));
  CHECK_FALSE(table.optional_number("x").has_value());
  LONGS_EQUAL(0, reader.root().tables("many").size());
  CHECK_EQUAL("", error_of(reader));
}

TEST(TomlReading, AMissingKeyIsNamedWithItsTable) {
  TomlReader reader("[lamps]\npulse_us = 1\n", "rig.toml");
  TomlTable lamps = reader.root().table("lamps");
  lamps.number("delay_us");
  lamps.number("pulse_us");
  CHECK_EQUAL("rig.toml:1: lamps.delay_us: is missing", error_of(reader));
  TomlReader absent("", "rig.toml");
  absent.root().table("lamps").number("delay_us");
  STRCMP_CONTAINS("lamps.delay_us: is missing", error_of(absent).c_str());
}

TEST(TomlReading, NumbersKeepTheirRange) {
  CHECK_EQUAL("f.toml:2: x: must be at least 1, is 0.5", complaint("0.5", {1, 2}));
  CHECK_EQUAL("f.toml:2: x: must be at most 2, is 3", complaint("3", {1, 2}));
  CHECK_EQUAL("f.toml:2: x: must be a finite number", complaint("nan", {1, 2}));
  CHECK_EQUAL("f.toml:2: x: must be a finite number", complaint("inf"));
  CHECK_EQUAL("f.toml:2: x: must be a number", complaint("\"3\""));
  CHECK_EQUAL("f.toml:2: x: must be a number", complaint("true"));
  CHECK_EQUAL("", complaint("2", {1, 2}));
}

TEST(TomlReading, EachTypeIsStrict) {
  const auto ask = [](const char* text, auto&& question) {
    TomlReader reader(text, "f.toml");
    TomlTable root = reader.root();
    question(root);
    return error_of(reader);
  };
  CHECK_EQUAL("f.toml:1: n: must be a whole number", ask("n = 1.5", [](TomlTable& t) { t.integer("n"); }));
  CHECK_EQUAL("f.toml:1: b: must be true or false",
              ask("b = 1", [](TomlTable& t) { t.boolean_or("b", false); }));
  CHECK_EQUAL("f.toml:1: s: must be text in quotes", ask("s = 1", [](TomlTable& t) { t.string("s"); }));
  CHECK_EQUAL("f.toml:1: t: must be a table", ask("t = 1", [](TomlTable& t) { t.table("t"); }));
  CHECK_EQUAL("f.toml:1: a: must be an array of numbers",
              ask("a = [1, \"2\"]", [](TomlTable& t) { t.numbers_or("a", {}); }));
  STRCMP_CONTAINS("written [[f]]", ask("f = 1", [](TomlTable& t) { t.tables("f"); }).c_str());
  CHECK_EQUAL("f.toml:1: w: must be one of free, gated, is \"wild\"", ask("w = \"wild\"", [](TomlTable& t) {
                t.choice_or("w", "free", {"free", "gated"});
              }));
}

TEST(TomlReading, AKeyNobodyAskedForIsAnError) {
  TomlReader reader("a = 1\n[t]\nb = 2\nc = 3\n", "f.toml");
  reader.root().number("a");
  reader.root().table("t").number("b");
  CHECK_EQUAL("f.toml:4: t.c: unknown key", error_of(reader));
  TomlReader in_array("[[f]]\na = 1\n[[f]]\nb = 1\n", "f.toml");
  for (TomlTable& t : in_array.root().tables("f")) t.number_or("a", 0.0);
  CHECK_EQUAL("f.toml:4: f[2].b: unknown key", error_of(in_array));
}

TEST(TomlReading, AKeyNobodyAskedForComesBeforeWhatIsMissingAndAfterWhatIsWrong) {
  const auto ask = [](const char* text) {
    TomlReader reader(text, "f.toml");
    TomlTable lamps = reader.root().table("lamps");
    lamps.number("delay_us");
    lamps.number_or("pulse_us", 1.0);
    return error_of(reader);
  };
  CHECK_EQUAL("f.toml:3: lamps.delai_us: unknown key; did you mean delay_us?",
              ask("[lamps]\npulse_us = 2\ndelai_us = 3\n"));
  CHECK_EQUAL("f.toml:1: lamp: unknown key; did you mean lamps?", ask("[lamp]\ndelay_us = 3\n"));
  CHECK_EQUAL("f.toml:2: lamps.delay_us: must be a number", ask("[lamps]\ndelay_us = \"3\"\npuls_us = 2\n"));
}

TEST(TomlReading, ASyntaxErrorIsSaidByLineAndComesFirst) {
  TomlReader reader("a = 1\nb = = 2\n", "f.toml");
  reader.root().number("zzz");
  STRCMP_CONTAINS("f.toml:2: ", error_of(reader).c_str());
}

TEST(TomlReading, TheFirstErrorIsKept) {
  TomlReader reader("a = \"x\"\nb = \"y\"\n", "f.toml");
  reader.root().number("a");
  reader.root().number("b");
  CHECK_EQUAL("f.toml:1: a: must be a number", error_of(reader));
}

TEST(TomlReading, ACallersOwnErrorHasTheKeysLine) {
  TomlReader reader("a = 1\nb = 2\n", "f.toml");
  TomlTable root = reader.root();
  root.number("a");
  root.number("b");
  root.error_at("b", "must be larger than a by 2");
  CHECK_EQUAL("f.toml:2: b: must be larger than a by 2", error_of(reader));
}

TEST(TomlReading, InheritingTakesWhatTheDocumentLacksTableByTable) {
  TomlReader child("a = 1\n[t]\nb = 2\n[[f]]\nx = 1\n", "child.toml");
  child.inherit(
      TomlReader("a = 10\nz = 5\n[t]\nb = 20\nc = 30\n[[f]]\nx = 2\n[[f]]\nx = 3\n", "parent.toml"));
  TomlTable root = child.root();
  DOUBLES_EQUAL(1.0, root.number("a"), 0.0);
  DOUBLES_EQUAL(5.0, root.number("z"), 0.0);
  DOUBLES_EQUAL(2.0, root.table("t").number("b"), 0.0);
  DOUBLES_EQUAL(30.0, root.table("t").number("c"), 0.0);
  LONGS_EQUAL(1, root.tables("f").size());
  DOUBLES_EQUAL(1.0, root.tables("f")[0].number("x"), 0.0);
  CHECK_EQUAL("", error_of(child));
}

TEST(TomlReading, WhatWasInheritedNamesItsOwnFile) {
  TomlReader child("[t]\nb = 2\n", "child.toml");
  child.inherit(TomlReader("\n[t]\nc = \"x\"\n", "parent.toml"));
  TomlTable t = child.root().table("t");
  t.number("b");
  t.number("c");
  CHECK_EQUAL("parent.toml:3: t.c: must be a number", error_of(child));
  TomlReader unasked("a = 1\n", "child.toml");
  unasked.inherit(TomlReader("\n\nq = 1\n", "parent.toml"));
  unasked.root().number("a");
  CHECK_EQUAL("parent.toml:3: q: unknown key", error_of(unasked));
}

TEST(TomlReading, InheritingKeepsTheFirstSyntaxError) {
  TomlReader child("a = 1\n", "child.toml");
  child.inherit(TomlReader("b = = 1\n", "parent.toml"));
  CHECK(child.error_so_far().has_value());
  STRCMP_CONTAINS("parent.toml:1: ", child.error_so_far()->message.c_str());
}

TEST(TomlReading, ARemovedKeyIsAsIfItHadNotBeenWritten) {
  TomlReader reader("a = 1\n[t]\nb = 2\nc = 3\n", "f.toml");
  reader.remove("", "a");
  reader.remove("t", "b");
  reader.remove("t", "none");
  reader.remove("none", "b");
  CHECK(!reader.root().has("a") && !reader.root().table("t").has("b"));
  CHECK(!reader.error_so_far().has_value());
  CHECK_EQUAL("f.toml:4: t.c: unknown key", error_of(reader));
}
