// lcm-spy's own search for types finds ours in the jar.
#include <string>

#include "tests/support/program_run.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;

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
  check_prints(run, {"Found 16 LCM types", "class strobe_msgs.shot_t"});
#else
  std::puts("not built: the jar needs default-jdk-headless and liblcm-java");
#endif
}
