// Others that read what strobe stored: Python, by the example script and the module for logs; lcm-spy.
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/host/others/stored_example.hpp"
#include "tests/support/program_run.hpp"
#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

using namespace strobe;
using others::StoredExample;

namespace {

constexpr const char* kPython = "/usr/bin/python3";  // Debian's: numpy is its

testing::CompletedProcess python(const std::string& script) {
  return testing::run_program({kPython, "-B", "-c", script},
                              {{"PYTHONPATH", STROBE_BUILD_DIR "/lib/python3/dist-packages"}});
}

std::string quoted(const std::filesystem::path& path) { return nlohmann::json(path.string()).dump(); }

}  // namespace

TEST_GROUP(Python) { StoredExample stored; };

TEST(Python, ExampleGivesMeanAndStandardErrorOfTheShotsThatCount) {
  const auto run =
      testing::run_program({STROBE_SOURCE_DIR "/host/examples/read_session.py", stored.folder.path()});
  check_prints(run, {"2 of 3 shots count"});
  // Mean of 0.80 and 0.84; half their difference is the mean's standard error.
  STRCMP_CONTAINS("\ne                  1        2         0.82            0.02\n", run.out.c_str());
  STRCMP_CONTAINS("\nvx_td_mps          m/s      0          nan             nan\n", run.out.c_str());
}

TEST(Python, ReadsALogsMessagesWithTheirSeals) {
  const auto lines =
      jsons_of(python("import json, strobe_log\n"
                      "key = strobe_log.read_key(" +
                      quoted(stored.key_file) +
                      ")\n"
                      "for r in strobe_log.read(" +
                      quoted(stored.log()) +
                      ", key=key):\n"
                      "  print(json.dumps([r.kind, r.utc_us, r.message.boot_id, r.seal.sender,\n"
                      "                    r.seal.number, r.seal.fingerprint, r.verified]))\n"));
  LONGS_EQUAL(4, lines.size());
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const nlohmann::json expected{i < 3 ? "EVENT" : "SHOT",
                                  1'769'851'800'000'000,
                                  others::kBoot,
                                  others::kBoot,
                                  i + 1,
                                  stored.key.fingerprint(),
                                  true};
    CHECK_EQUAL(expected.dump(), lines[i].dump());
  }
}

TEST(Python, ReadsFramesOfFormerVersions) {
  for (const char* version : {"2", "3", "4"}) {
    const std::string type = "frame_" + std::string(version) + "_t";
    const auto lines =
        jsons_of(python("import json, struct, strobe_log\n"
                        "from strobe_msgs." + type + " import " + type + "\n"
                        "frame = " + type + "()\n"
                        "frame.schema_version, frame.shot_id = " + version + ", 7\n"
                        "channel, data = b'STROBE/bench/FRAME', frame.encode()\n"
                        "path = " +
                        quoted(std::filesystem::path(stored.folder.path()) / "former.lcmlog") +
                        "\n"
                        "with open(path, 'wb') as log:\n"
                        "  log.write(struct.pack('>4sqqii', b'\\xed\\xa1\\xda\\x01', 0, 0, len(channel), len(data)))\n"
                        "  log.write(channel + data)\n"
                        "r = next(strobe_log.read(path))\n"
                        "print(json.dumps([r.message.schema_version, r.message.shot_id]))\n"));
    CHECK_EQUAL(std::string("[") + version + ",7]", lines.at(0).dump());
  }
}

TEST(Python, BelievesNoPacketThatWasAlteredOrIsOfAnotherKey) {
  const auto lines =
      jsons_of(python("import json, strobe_log\n"
                      "key = strobe_log.read_key(" +
                      quoted(stored.key_file) +
                      ")\n"
                      "_, channel, p = next(strobe_log.packets(" +
                      quoted(stored.log()) +
                      "))\n"
                      "sealed = strobe_log.is_sealed_with\n"
                      "altered = bytes([p[0] ^ 1]) + p[1:]\n"
                      "print(json.dumps([sealed(key, channel, p), sealed(key, channel, altered),\n"
                      "  sealed(key, channel + 'x', p), sealed(bytes(32), channel, p),\n"
                      "  sealed(key, channel, p[:-44])]))\n"));
  CHECK_EQUAL("[true,false,false,false,false]", lines.at(0).dump());
}

TEST(Python, GoesOnAfterDamageAndTellsOfIt) {
  std::string log = testing::read_text(stored.log());
  log.insert(0, "damage");
  log += "torn";
  testing::write_text(stored.log(), log);
  const auto lines =
      jsons_of(python("import json, strobe_log\n"
                      "told = []\n"
                      "n = sum(1 for _ in strobe_log.read(" +
                      quoted(stored.log()) +
                      ", on_damage=lambda at, size: told.append([at, size])))\n"
                      "print(json.dumps([n, told]))\n"));
  const nlohmann::json expected{4, {{0, 6}, {log.size() - 4, 4}}};
  CHECK_EQUAL(expected.dump(), lines.at(0).dump());
}

TEST(Python, PutsMessagesIntoColumns) {
  const auto lines = jsons_of(
      python("import json, strobe_log\n"
             "shots = [r.message for r in strobe_log.read(" +
             quoted(stored.log()) +
             ", kinds={'SHOT'})]\n"
             "flashes = strobe_log.columns(shots[0].flashes)\n"
             "print(json.dumps([strobe_log.columns(shots)['plan.period_ns'].tolist(),\n"
             "                  (flashes['observed_a_ns'] - flashes['commanded_ns']).tolist()]))\n"));
  CHECK_EQUAL("[[3000000],[4000,4000]]", lines.at(0).dump());
}

/// lcm-spy's own search for types finds ours in the jar.
TEST_GROUP(LcmSpy){};

TEST(LcmSpy, FindsEveryTypeInTheJar) {
#ifdef STROBE_MESSAGES_JAR
  testing::TemporaryFolder folder;
  testing::write_text(
      folder / "Types.java",
      "public class Types {\n"
      "  public static void main(String[] words) throws Exception {\n"
      "    var types = new lcm.spy.LCMTypeDatabase();\n"
      "    var shot = new strobe_msgs.shot_t();\n"
      "    shot.abort_reason = \"\";\n"
      "    System.out.println(types.getClassByFingerprint(strobe_msgs.shot_t.LCM_FINGERPRINT));\n"
      "  }\n"
      "}\n");
  const auto run =
      testing::run_program({"java", "-cp", STROBE_LCM_JAR ":" STROBE_MESSAGES_JAR, folder / "Types.java"});
  check_prints(run, {"Found 21 LCM types", "class strobe_msgs.shot_t"});
#else
  std::puts("not built: the jar needs default-jdk-headless and liblcm-java");
#endif
}
