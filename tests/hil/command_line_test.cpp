// Bad input: the exit status and exactly one line on standard error that says what and where.
#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <string>
#include <vector>

#include "tests/support/private_network.hpp"

#include "tests/hil/expectations.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe::hil;
using namespace strobe::testing;
using namespace std::chrono_literals;

namespace {

struct Case {
  const char* what;
  Command command;
  int code;
  std::string word;  ///< what the line must name
};

std::string complaints(const std::vector<Case>& cases) {
  std::string wrong;
  for (const Case& each : cases) {
    const CompletedProcess finished = run_process(each.command, 20s);
    const auto lines = std::count(finished.err.begin(), finished.err.end(), '\n');
    const int code = finished.status ? finished.status->code : -1;
    if (code == each.code && lines == 1 && finished.err.find(each.word) != std::string::npos) continue;
    wrong += fmt::format("\n  {}: exit {} (wanted {}), {} lines, looked for \"{}\" in:\n{}", each.what, code,
                         each.code, lines, each.word, finished.err);
  }
  return wrong;
}

Command with_strobe(std::vector<std::string> words) {
  words.insert(words.begin(), program("strobe"));
  return {words, {}, {}, {}};
}

/// A frame of five images that the reduction accepts; `{}` stands for one more member.
const char* const kFrame =
    R"({"shot_id":1,"ball_diameter_m":0.0651,"surface_px":[[0,100],[100,100],[900,100],[1000,100]],"images":[)"
    R"({"time_s":0.0,"leg":"incoming","centre_px":[100,600],"diameter_px":260,"equator_rad":0.1},)"
    R"({"time_s":0.003,"leg":"incoming","centre_px":[250,450],"diameter_px":260,"equator_rad":0.1},)"
    R"({"time_s":0.006,"leg":"incoming","centre_px":[400,300],"diameter_px":260,"equator_rad":0.1},)"
    R"({"time_s":0.015,"leg":"rebound","centre_px":[700,400],"diameter_px":260,"equator_rad":0.2},)"
    R"({"time_s":0.018,"leg":"rebound","centre_px":[800,500],"diameter_px":260,"equator_rad":0.3},)"
    R"({"time_s":0.021,"leg":"rebound","centre_px":[900,600],"diameter_px":260,"equator_rad":0.4}]})";

}  // namespace

TEST_GROUP(CommandLine) {
  TemporaryFolder folder;

  std::string file(const std::string& name, const std::string& text) const {
    write_text(folder / name, text);
    return folder / name;
  }
  /// A session whose run was asked for three shots.
  std::string recorded_run() const {
    std::filesystem::create_directory(folder / "recorded");
    file("recorded/plan.toml", "period_us = 3000\n");
    file(
        "recorded/runs.jsonl",
        R"({"host_id":"5","shots":3,"until":false,"session_shots":3,"notes":{"spin":"zero"},"plan_file":"plan.toml"})"
        "\n");
    return folder / "recorded";
  }
  std::string rig(const std::string& name, const std::string& from, const std::string& to) const {
    return file(name, replaced(read_text(share("rig.toml")), from, to));
  }
};

TEST(CommandLine, EachProgramTellsItsVersion) {
  for (const char* name : {"strobed", "strobe", "strobe-sim"}) {
    const auto told = run_process({{program(name), "--version"}, {}, {}, {}}, 10s);
    CHECK_TEXT(told.status == ExitStatus({0, 0}), name);
    CHECK_EQUAL(std::string(STROBE_VERSION "\n"), told.out);
  }
}

TEST(CommandLine, WrongRigFilesAreNamedWithTheirLine) {
  const std::string session = folder / "session";
  const auto strobed = [&](const std::string& config) {
    return Command{
        {program("strobed"), "--config", config, "--session", session, "--allow-no-rt"}, {}, {}, {}};
  };
  CHECK_EQUAL(
      "", complaints({
              {"no such file", strobed(folder / "none.toml"), 2, "none.toml"},
              {"not TOML", strobed(file("broken.toml", "rig = \"bench\"\n[chip\n")), 2, "broken.toml:2"},
              {"unknown key", strobed(rig("unknown.toml", "priority = 80", "prority = 80")), 2, "prority"},
              {"text for a number", strobed(rig("text.toml", "pulse_us = 50 ", "pulse_us = \"fifty\" ")), 2,
               "pulse_us"},
              {"not a number", strobed(rig("nan.toml", "pulse_us = 50 ", "pulse_us = nan ")), 2, "pulse_us"},
              {"beyond its range", strobed(rig("range.toml", "max_open_s = 2.0", "max_open_s = -2.0")), 2,
               "max_open_s"},
              {"a line missing", strobed(rig("missing.toml", "trigger  = { line = \"TRIGGER\" }", "")), 2,
               "trigger"},
              {"one line twice", strobed(rig("twice.toml", "line = \"STROBE_B\"", "line = \"STROBE_A\"")), 2,
               "strobe_b"},
              {"bad rig name", strobed(rig("name.toml", "rig = \"bench\"", "rig = \"a/b\"")), 2, "rig"},
          }));
}

TEST(CommandLine, LcmUrlsThatAreNotReadToTheLastCharacterAreRefusedInOptionAndRigFile) {
  const std::string session = folder / "session";
  std::vector<Case> cases;
  for (const char* url : {"udpm://239.255.76.67", "udpm://239.255.76.67:0x1df3", "udpm://239.255.76.67: 7667",
                          "tcpq://127.0.0.1:7700", "memq://", ""}) {
    const std::string config = rig("url" + std::to_string(cases.size()) + ".toml", "[chip]",
                                   "lcm_url = \"" + std::string(url) + "\"\n[chip]");
    const std::vector<std::string> firmware{program("strobed"), "--session", session, "--allow-no-rt",
                                            "--config"};
    const std::vector<std::string> simulator{program("strobe-sim"), "run", "--scene", "zero_23"};
    const auto with = [](std::vector<std::string> words, const std::vector<std::string>& more) {
      words.insert(words.end(), more.begin(), more.end());
      return Command{words, {}, {}, {}};
    };
    const std::string fine = share("rig.toml");
    cases.push_back({url, with(firmware, {fine, "--lcm-url", url}), 2, "--lcm-url"});
    cases.push_back({url, with(firmware, {fine, "--check", "--lcm-url", url}), 2, "--lcm-url"});
    cases.push_back({url, with(firmware, {config}), 2, "lcm_url"});
    cases.push_back({url, with_strobe({"live", "--rig", fine, "--lcm-url", url}), 2, "--lcm-url"});
    cases.push_back({url, with_strobe({"live", "--rig", config}), 2, "lcm_url"});
    cases.push_back(
        {url, with_strobe({"fire", "--rig", fine, "--session", session, "--lcm-url", url}), 2, "--lcm-url"});
    cases.push_back({url, with_strobe({"fire", "--rig", config, "--session", session}), 2, "lcm_url"});
    cases.push_back({url, with(simulator, {"--lcm-url", url, "--", "true"}), 2, "--lcm-url"});
  }
  for (Case& each : cases)
    each.command.environment["LCM_DEFAULT_URL"] = "udpm://239.255.76.67";  // never read
  CHECK_EQUAL("", complaints(cases));
}

TEST(CommandLine, ChipsAndLinesThatCannotBeHadAreNamed) {
  RigFixtureOptions options;
  options.shell = "sleep 100";  // a chip with nobody on it
  RigFixture bench(options);
  CHECK(bench.sim().wait_for_err("strobe-sim: scene", 20s));
  const std::string session = folder / "session";
  const auto strobed = [&](const std::string& config) {
    return bench.strobed(
        {"--config", config, "--session", session, "--allow-no-rt", "--lcm-url", bench.lcm_url()});
  };
  Command no_chip = strobed(share("rig.toml"));
  no_chip.environment.clear();
  CHECK_EQUAL(
      "", complaints({
              {"no chip", no_chip, 2, "gpiochip0"},
              {"no such chip", strobed(rig("chip.toml", "\"gpiochip0\"", "\"gpiochip7\"")), 2, "gpiochip7"},
              {"another device", strobed(rig("null.toml", "\"gpiochip0\"", "\"/dev/null\"")), 2,
               "\"/dev/null\" is no GPIO chip"},
              {"no such line", strobed(rig("line.toml", "\"SHUTTER\"", "\"SHUTER\"")), 2, "SHUTER"},
              {"no such number", strobed(rig("offset.toml", "\"SHUTTER\"", "99")), 2, "99"},
          }));
}

TEST(CommandLine, KeysThatAreNotKeptWellAreNamed) {
  const std::string loose = file("loose.key", std::string(64, 'a') + "\n");
  std::filesystem::permissions(loose, std::filesystem::perms(0644));
  const std::string short_one = file("short.key", "abc\n");
  std::filesystem::permissions(short_one, std::filesystem::perms(0600));
  const std::string rig_with_key = rig("key.toml", "#key_file = \"lab.key\"   ", "key_file = \"loose.key\"");
  const auto strobed = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{program("strobed"), "--session", folder / "session", "--allow-no-rt"};
    words.insert(words.end(), more.begin(), more.end());
    return Command{words, {}, {}, {}};
  };
  CHECK_EQUAL("", complaints({
                      {"no such key", strobed({"--config", share("rig.toml"), "--key-file", folder / "none"}),
                       2, "strobe key --new"},
                      {"others can read it", strobed({"--config", share("rig.toml"), "--key-file", loose}), 2,
                       "chmod 600"},
                      {"the rig file's", strobed({"--config", rig_with_key}), 2, "chmod 600"},
                      {"not a key", strobed({"--config", share("rig.toml"), "--key-file", short_one}), 2,
                       "64 hexadecimal digits"},
                      {"the host's", with_strobe({"fire", "--key-file", loose}), 2, "chmod 600"},
                      {"the host's rig file's", with_strobe({"fire", "--rig", rig_with_key}), 2, "loose.key"},
                      {"a new key over an old one", with_strobe({"key", "--new", loose}), 2, "already"},
                  }));
}

TEST(CommandLine, LinesThatAnotherProgramHoldsAreNamed) {
  ReadyRig bench;
  const Command second = bench.strobed({"--config", bench.rig_file(), "--session", folder / "session",
                                        "--allow-no-rt", "--lcm-url", bench.lcm_url()});
  const Command safe = bench.strobed({"--safe", "--config", bench.rig_file()});
  CHECK_EQUAL(
      "", complaints({{"busy chip", second, 2, "busy"},
                      {"busy outputs", safe, 1, "strobe_a: cannot take line 0: Device or resource busy"}}));
}

TEST(CommandLine, FilesAndFoldersThatAreNotThereAreNamedWithTheOptionOrFieldThatNamesThem) {
  const std::string none = folder / "none";
  const std::string lost = rig("lost.toml", "#calibration = ", "calibration = ");
  const std::string picture = file("picture.png", "no picture");
  const std::string scaled = file("scaled.toml", "rig = \"b\"\n[camera]\npx_per_m = 2000\nfolder = \"none\"\n");
  const auto fire = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"fire", "--session", folder / "session"});
    return with_strobe(more);
  };
  CHECK_EQUAL("", complaints({
                      {"rig file", fire({"--rig", none}), 2, "rig file " + none + ": No such file"},
                      {"plan", fire({"--plan", none}), 2, "--plan: " + none + ": No such file"},
                      {"calibration", fire({"--rig", lost}), 2, lost + ": camera.calibration: "},
                      {"camera's folder", fire({"--rig", scaled}), 2, "camera.folder of the rig file: " + none},
                      {"photographs", fire({"--rig", scaled, "--photographs", none}), 2, "--photographs: " + none},
                      {"times", with_strobe({"digitize", picture, "--times", none}), 2, "--times: " + none},
                      {"corrections", with_strobe({"digitize", picture, "--edit", none}), 2, "--edit: " + none},
                      {"session", with_strobe({"series", none}), 2, none + ": no such folder of a session"},
                  }));
}

TEST(CommandLine, WrongFramesAreNamedWithTheirLine) {
  const auto reduce = [&](const std::string& path) {
    return with_strobe({"reduce", path, "--format", "frame"});
  };
  const std::string good = std::string(kFrame) + "\n";
  CHECK_EQUAL(
      "",
      complaints({
          {"no such file", reduce(folder / "none.jsonl"), 2, "none.jsonl"},
          {"letters in a number", reduce(file("letters.jsonl", replaced(good, "0.003", "0.0O3"))), 2,
           "letters.jsonl:1"},
          {"NaN", reduce(file("nan.jsonl", good + replaced(good, "0.003", "NaN"))), 1, "nan.jsonl:2"},
          {"cut in the middle", reduce(file("cut.jsonl", good + good.substr(0, good.size() / 2))), 1,
           "cut.jsonl:2"},
          {"no images", reduce(file("none_key.jsonl", "{\"shot_id\":1}\n")), 2, "none_key.jsonl:1"},
          {"no frames", reduce(file("empty.jsonl", "\n \n")), 2, "empty.jsonl: no frames"},
          {"a flight for another estimator",
           with_strobe({"reduce", file("good.jsonl", good), "--estimator", "two-point", "--flight", "all"}),
           2, "--flight"},
          {"unknown estimator",
           with_strobe({"reduce", file("good.jsonl", good), "--format", "frame", "--estimator", "guess"}), 2,
           "guess"},
          {"unknown format", with_strobe({"reduce", file("good.jsonl", good), "--format", "card"}), 2,
           "card"},
      }));
  CHECK_EQUAL(ExitStatus({0, 0}), run_process(reduce(file("good.jsonl", good)), 20s).status);
}

TEST(CommandLine, LegacyFilesCutOrWithLettersAreNamedWithTheirLine) {
  const auto reduce = [&](const std::string& path) {
    return with_strobe({"reduce", path, "--format", "legacy", "--estimator", "legacy"});
  };
  const std::string start =
      "0.003\n2 17\n0 100\n100 100\n900 100\n1000 100\n\n100 600\n230 600\n50 590\n150 610\n\n250 450\n";
  CHECK_EQUAL(
      "",
      complaints({
          {"cut in the middle", reduce(file("cut.dat", start)), 2, "cut.dat"},
          {"letters in a number", reduce(file("letters.dat", replaced(start, "900 100", "9OO 100"))), 2,
           "letters.dat:5"},
          {"not a number", reduce(file("nan.dat", replaced(start, "900 100", "nan 100"))), 2, "nan.dat:5"},
          {"no period", reduce(file("period.dat", "period\n")), 2, "period.dat:1"},
          {"empty", reduce(file("empty.dat", "")), 2, "empty.dat"},
      }));
}

TEST(CommandLine, WrongOptionsOfStrobeAreNamed) {
  CHECK_EQUAL(
      "",
      complaints({
          {"no such command", with_strobe({"explode"}), 2, "explode"},
          {"letters in a number", with_strobe({"fire", "--shots", "nine"}), 2, "nine"},
          {"no shots", with_strobe({"fire", "--shots", "0"}), 2, "shots"},
          {"unknown spin", with_strobe({"fire", "--shots", "1", "--spin", "side"}), 2, "side"},
          {"a note without a value", with_strobe({"fire", "--shots", "1", "--note", "remarks"}), 2,
           "remarks"},
          {"no such plan", with_strobe({"fire", "--shots", "1", "--plan", folder / "none.toml"}), 2,
           "none.toml"},
          {"wrong plan",
           with_strobe(
               {"fire", "--shots", "1", "--plan", file("plan.toml", "period_us = 3000\nperid = 1\n")}),
           2, "plan.toml:2"},
          {"a plan beyond the rig's limits",
           with_strobe({"fire", "--shots", "1", "--plan", file("fast.toml", "period_us = 1000\n")}), 2,
           "fast.toml: period_us: a period of 1000 us is shorter than the lamps'"},
          {"shots of a run and of the session", with_strobe({"fire", "--shots", "1", "--until", "2"}), 2,
           "--until"},
          {"dry shots of the session", with_strobe({"fire", "--until", "2", "--dry"}), 2, "--dry"},
          {"dry shots until known", with_strobe({"fire", "--until-known", "e:0.01", "--dry"}), 2, "--dry"},
          {"nothing to be known", with_strobe({"fire", "--until-known", "e:0.01,mu:0%"}), 2,
           "--until-known mu:0%: must be a number above 0"},
          {"a run to go on with, of no session", with_strobe({"fire", "--resume"}), 2, "--session"},
          {"no run to go on with", with_strobe({"fire", "--resume", "--session", folder / "none"}), 2,
           "runs.jsonl"},
          {"a run to go on with, and other shots",
           with_strobe({"fire", "--resume", "--session", recorded_run(), "--shots", "5"}), 2,
           "--shots excludes --resume"},
          {"a run to go on with, and another spin",
           with_strobe({"fire", "--resume", "--session", recorded_run(), "--spin", "top"}), 2,
           "--resume excludes --spin"},
          {"a run to go on with, and another plan",
           with_strobe({"fire", "--resume", "--session", recorded_run(), "--plan",
                        file("other.toml", "period_us = 4000\n")}),
           2, "--resume excludes --plan"},
          {"no such log", with_strobe({"replay", folder / "none.lcmlog"}), 2, "none.lcmlog"},
          {"no such rig file", with_strobe({"live", "--rig", folder / "none.toml"}), 2, "none.toml"},
          {"restitution above 1",
           with_strobe({"predict", "--vx", "15", "--vy", "-6", "--omega", "0", "--e", "1.5"}), 2, "e must"},
          {"ball leaving the surface", with_strobe({"predict", "--vx", "15", "--vy", "6", "--omega", "0"}), 2,
           "vy"},
          {"not a number", with_strobe({"predict", "--vx", "nan", "--vy", "-6", "--omega", "0"}), 2, "vx"},
      }));
}

TEST(CommandLine, ASessionThatARunWritesIsOnlyReadByOthers) {
  const std::string session = folder / "session", again = rig("again.toml", "priority = 80", "priority = 79");
  const std::string url = private_lcm_url();
  Process first(with_strobe({"fire", "--session", session, "--lcm-url", url, "--wait", "3600"}),
                folder.path());
  CHECK(first.wait_for_err("session " + session, kLongestWait));
  const std::string whose = fmt::format("process {}, since 20", first.pid());
  CHECK_EQUAL(
      "", complaints({
              {"fire", with_strobe({"fire", "--session", session, "--lcm-url", url}), 2, whose.c_str()},
              {"fire --until", with_strobe({"fire", "--until", "2", "--session", session, "--lcm-url", url}),
               2, whose.c_str()},
              {"commission",
               with_strobe({"commission", "--yes", "--rig", again, "--session", session, "--lcm-url", url}),
               2, whose.c_str()},
              {"replay --results", with_strobe({"replay", session, "--results"}), 2, whose.c_str()},
              {"replay", with_strobe({"replay", session, "--json"}), 1, "no shot was fired"},
          }));
  first.signal(SIGKILL);
  first.wait(kLongestWait);
  const auto next = ran(with_strobe({"fire", "--session", session, "--lcm-url", url, "--wait", "0.1"}), 1);
  CHECK_FALSE(std::filesystem::exists(folder / "session" / "session.lock"));
}

TEST(CommandLine, ATableThatCannotBeReadIsNotTakenForAnEmptyOne) {
  const std::string session = recorded_run(), url = private_lcm_url();
  file("recorded/results.csv", "");
  std::filesystem::resize_file(folder / "recorded/results.csv", std::uintmax_t{1} << 40);
  const auto fire = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"fire", "--session", session, "--lcm-url", url, "--wait", "0.1"});
    return with_strobe(more);
  };
  CHECK_EQUAL("", complaints({{"until", fire({"--until", "3"}), 2, "recorded/results.csv: a line is longer"},
                              {"shots", fire({"--shots", "1"}), 2, "recorded/results.csv: a line is longer"},
                              {"resume", fire({"--resume"}), 2, "recorded/results.csv: a line is longer"}}));
}

TEST(CommandLine, FiringWithoutAStrobedEndsWithAClearMessage) {
  const std::string url = private_lcm_url();
  const CompletedProcess finished = run_process(
      with_strobe({"fire", "--shots", "1", "--session", folder / "session", "--lcm-url", url, "--wait", "1"}),
      30s);
  CHECK_TEXT(finished.status == ExitStatus({1, 0}), finished.err.c_str());
  STRCMP_CONTAINS("strobed", finished.err.c_str());
}
