// Programs asked about photographs: their answers, and a whole evaluation.
#include "tests/real/evaluation.hpp"

#include <opencv2/imgproc.hpp>
#include <string>

#include "tests/real/report.hpp"
#include "tests/support/pictures.hpp"
#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

using namespace strobe::real;
using strobe::Result;
using strobe::testing::TemporaryFolder;

namespace {

Question question(const std::filesystem::path& file = "/nowhere") {
  return {file, cv::Mat(200, 300, CV_8UC1, cv::Scalar(0)), 0.05, 2000.0, 12.0};
}

Result<Answer> answer_of(const std::string& command, const Question& asked = question()) {
  return finder_of(command)(asked);
}

std::string complaint(const std::string& text) {
  const auto answer = parse_answer(text, 200, 100.0);
  return answer ? "" : answer.error().message;
}

/// Discs of 60 px on a dark ground, each with a little limb darkening and an edge of a pixel.
cv::Mat balls_at(const std::vector<Point>& centres) {
  cv::Mat light(400, 600, CV_32F, cv::Scalar(15));
  for (int y = 0; y < light.rows; ++y)
    for (int x = 0; x < light.cols; ++x)
      for (const Point& c : centres) {
        const double r = std::hypot(x - c.x, y - c.y) / 30.0;
        const double edge = std::clamp(30.0 * (1.0 - r) + 0.5, 0.0, 1.0);
        light.at<float>(y, x) += static_cast<float>(edge * (200.0 - 40.0 * r * r));
      }
  cv::Mat pixels;
  light.convertTo(pixels, CV_8U);
  return pixels;
}

std::vector<Photograph> collection(const TemporaryFolder& folder) {
  const std::vector<Point> centres{{80.2, 100.7}, {200.5, 180.0}, {330.0, 250.4}, {470.3, 300.1}};
  strobe::testing::write_picture(folder / "a.png", balls_at(centres));
  Photograph photograph{"a.png", folder / "a.png", 0.03, 2000.0, {}, {}, false, false, {}};
  for (const Point& c : centres) photograph.balls.push_back({{c.x, c.y, 60.0}, Kind::ball});
  return {photograph};
}

Asked all_alterations() {
  Asked asked;
  for (const Alteration& each : alterations()) asked.alterations.push_back(&each);
  asked.jobs = 2;
  return asked;
}

}  // namespace

TEST_GROUP(RealFinders){};

TEST(RealFinders, TakesCirclesAndFrames) {
  const auto circles = parse_answer(R"({"circles": [{"x": 1, "y": 2, "d": 3, "score": 0.5}]})", 200, 100.0);
  DOUBLES_EQUAL(2.0, circles->circles.at(0).y, 0.0);
  CHECK_FALSE(circles->circles[0].sds.has_value());
  const auto sure =
      parse_answer(R"([{"x": 1, "y": 2, "d": 3, "x_sd": 0.1, "y_sd": 0.2, "d_sd": 0.3}])", 200, 100.0);
  DOUBLES_EQUAL(0.2, sure->circles.at(0).sds->y, 0.0);
  LONGS_EQUAL(0, parse_answer("[]", 200, 100.0)->circles.size());
  const auto frame = parse_answer(
      R"({"images": [{"centre_px": [10, 20], "diameter_px": 30, "centre_cov_px2": [[0.04, 0.01], [0.01, 0.09]],
                      "diameter_sd_px": 0.4},
                     {"centre_px": [40, 50], "centre_cov_px2": null}],
          "unmeasured": [{"what": "image", "centre_px": [7, 8], "reason": "dim", "detail": "2 of 9"},
                         {"what": "top"}]})",
      200, 100.0);
  DOUBLES_EQUAL(179.0, frame->circles.at(0).y, 0.0);
  DOUBLES_EQUAL(30.0, frame->circles.at(0).d, 0.0);
  DOUBLES_EQUAL(0.2, frame->circles[0].sds->x, 1e-12);
  DOUBLES_EQUAL(0.3, frame->circles[0].sds->y, 1e-12);
  DOUBLES_EQUAL(0.4, frame->circles[0].sds->d, 1e-12);
  DOUBLES_EQUAL(100.0, frame->circles.at(1).d, 0.0);
  CHECK_FALSE(frame->circles[1].sds.has_value());
  LONGS_EQUAL(1, frame->refusals.size());
  DOUBLES_EQUAL(191.0, frame->refusals[0].at.y, 0.0);
  CHECK_EQUAL("dim: 2 of 9", frame->refusals[0].why);
}

TEST(RealFinders, OfSeveralLinesTheFirstCounts) {
  LONGS_EQUAL(1, parse_answer("[{\"x\": 1, \"y\": 2, \"d\": 3}]\ndone in 3 s\n", 200, 100.0)->circles.size());
}

TEST(RealFinders, SaysWhatIsWrongWithAnAnswer) {
  CHECK_EQUAL("is not JSON", complaint(""));
  CHECK_EQUAL("is not JSON", complaint("found 3"));
  CHECK_EQUAL("neither circles nor a frame", complaint("{}"));
  CHECK_EQUAL("circle 2 lacks x, y or a d above 0",
              complaint(R"([{"x": 1, "y": 2, "d": 3}, {"x": 1, "y": 2, "d": -3}])"));
  CHECK_EQUAL("circle 1 lacks x, y or a d above 0", complaint("[3]"));
  CHECK_EQUAL("an image has no centre_px", complaint(R"({"images": [{"centre_px": ["a", 1]}]})"));
  CHECK_EQUAL("an image has no centre_px", complaint(R"({"images": [7]})"));
  CHECK_EQUAL("images is no list", complaint(R"({"images": 7})"));
}

TEST(RealFinders, TellsAProgramFileAndScale) {
  const TemporaryFolder folder;
  const auto file = folder / "it's a shot.png";
  strobe::testing::write_text(file, "x");
  const std::string echo =
      "test -f {file} && echo '[{\"x\": {px_per_m}, \"y\": {ball_diameter_m}, \"d\": {size_tolerance}}]'";
  const auto answer = answer_of(echo, question(file));
  CHECK_TEXT(answer.has_value(), answer ? "" : answer.error().message.c_str());
  DOUBLES_EQUAL(2000.0, answer->circles.at(0).x, 0.0);
  DOUBLES_EQUAL(0.05, answer->circles.at(0).y, 0.0);
  DOUBLES_EQUAL(12.0, answer->circles.at(0).d, 0.0);
}

TEST(RealFinders, AProgramMayExitWith1ButNotFailInSilence) {
  CHECK(answer_of("echo '[]'; exit 1").has_value());
  CHECK_EQUAL("nowhere: the program ends with exit status 3: no balls today",
              answer_of("echo 'no balls today' >&2; exit 3").error().message);
  CHECK_EQUAL("nowhere: the program's answer: is not JSON; it says: Traceback",
              answer_of("echo Traceback >&2; exit 1").error().message);
  CHECK_EQUAL("nowhere: the program ends with signal 9: no message", answer_of("kill -9 $$").error().message);
}

TEST_GROUP(RealEvaluation){};

// Sharp discs: the blob detector's centre is that of contours at ten levels, and no alteration blurs or
// shades them by more than a pixel.
TEST(RealEvaluation, AFinderThatSeesAllKeepsAllInEachAlteration) {
  const TemporaryFolder folder;
  const auto photographs = collection(folder);
  const auto outcomes = evaluated(photographs, blob_finders().front().find, all_alterations());
  CHECK_TEXT(outcomes.has_value(), outcomes ? "" : outcomes.error().message.c_str());
  LONGS_EQUAL(alterations().size(), outcomes->size());
  for (const Outcome& outcome : *outcomes) {
    const std::string name(outcome.alteration->name);
    LONGS_EQUAL_TEXT(outcome.score.balls, outcome.score.found, name.c_str());
    LONGS_EQUAL_TEXT(0, outcome.score.strays.size(), name.c_str());
    CHECK_TEXT(rms(outcome.score.centre_px) < 1.0, name.c_str());
  }
  CHECK(breaches(*outcomes, {}).empty());
}

TEST(RealEvaluation, WhenStoppedItAsksNoMoreAndLeavesNoFileBehind) {
  const TemporaryFolder folder;
  const auto photographs = collection(folder);
  std::atomic<bool> stopped = false;
  std::filesystem::path altered;
  int asked_times = 0;
  const Finder finder = [&](const Question& question) -> Result<Answer> {
    altered = question.file;
    stopped = ++asked_times == 2;  // the first is asked about the file as it is
    return Answer{};
  };
  Asked asked = all_alterations();
  asked.jobs = 1;
  asked.stopped = &stopped;
  const auto outcomes = evaluated(photographs, finder, asked);
  CHECK_FALSE(outcomes.has_value());
  CHECK_EQUAL("stopped", outcomes.error().message);
  LONGS_EQUAL(2, asked_times);
  CHECK_FALSE(std::filesystem::exists(altered.parent_path()));
}

TEST(RealEvaluation, OpenCvsDetectorsSeeSharpDiscs) {
  const TemporaryFolder folder;
  const auto photographs = collection(folder);
  for (const auto& finders : {hough_finders(), blob_finders()}) {
    const auto best = best_of(finders, photographs, {});
    const auto outcomes = evaluated(photographs, best->find, {{&alterations().front()}});
    LONGS_EQUAL_TEXT(4, total(*outcomes, nullptr).found, best->name.c_str());
    LONGS_EQUAL_TEXT(0, total(*outcomes, nullptr).strays.size(), best->name.c_str());
  }
}

TEST(RealEvaluation, SaysWhichBoundDoesNotHoldAndWhatWasSaidOfAMissedBall) {
  const TemporaryFolder folder;
  const auto photographs = collection(folder);
  // Three of four balls, one invented; of the fourth it says why.
  const Finder finder = [&](const Question&) -> Result<Answer> {
    const auto& balls = photographs[0].balls;
    return Answer{{{balls[0]}, {balls[1]}, {balls[2]}, {{550.0, 50.0, 60.0}}},
                  {{{475.0, 300.0}, "dim: 2 of 9"}}};
  };
  const auto outcomes = evaluated(photographs, finder, {{&alterations().front()}});
  const auto broken = breaches(*outcomes, {});
  LONGS_EQUAL(2, broken.size());
  CHECK_EQUAL("as-is: recall 0.75, not at least 0.97", broken[0]);
  CHECK_EQUAL("as-is: invented 1, not at most 0.1", broken[1]);
  const std::string text = tables(*outcomes, photographs, true);
  STRCMP_CONTAINS("as-is, a.png: missed (470.3, 300.1) d 60.0: dim: 2 of 9\n", text.c_str());
  STRCMP_CONTAINS("as-is, a.png: invented (550.0, 50.0) d 60.0\n", text.c_str());
}

// Circles that are all 1 px off, by annotators that are so far from each other or nearer.
TEST(RealEvaluation, WhereItIsAnnotatedTwiceNoProgramMayBeWorseThanAPerson) {
  const TemporaryFolder folder;
  auto photographs = collection(folder);
  const Finder finder = [balls = photographs[0].balls](const Question&) -> Result<Answer> {
    Answer answer;
    for (const Ball& ball : balls) answer.circles.push_back({{ball.x + 1.0, ball.y, ball.d}});
    return answer;
  };
  for (const double apart : {1.1, 0.9}) {
    photographs[0].second = photographs[0].balls;
    for (Ball& ball : *photographs[0].second) ball.y += apart;
    const auto broken = breaches(*evaluated(photographs, finder, {{&alterations().front()}}), {});
    LONGS_EQUAL(apart < 1.0 ? 1 : 0, broken.size());
    if (!broken.empty()) CHECK_EQUAL("annotated twice: centre rms px 1, not at most 0.9", broken[0]);
  }
}

TEST(RealEvaluation, CountsTheBallsThatAnAlterationChanges) {
  const TemporaryFolder folder;
  const auto photographs = collection(folder);
  // It misses the left-most ball, whichever that is.
  const Finder finder = [&](const Question& asked) -> Result<Answer> {
    auto answer = blob_finders().front().find(asked);
    auto& circles = answer->circles;
    circles.erase(std::ranges::min_element(circles, {}, &Found::x));
    return answer;
  };
  Asked asked;
  for (const Alteration& each : alterations())
    if (each.name == "as-is" || each.name == "mirrored") asked.alterations.push_back(&each);
  const auto outcomes = evaluated(photographs, finder, asked);
  LONGS_EQUAL(2, changed(total(*outcomes, asked.alterations[0]), total(*outcomes, asked.alterations[1])));
}

// 600 x 400 px become 750 x 500, exactly 1.25 times as many.
TEST(RealEvaluation, ErrorsOnALargerPictureAreThoseOfThePhotograph) {
  const TemporaryFolder folder;
  const auto photographs = collection(folder);
  const Finder finder = [&](const Question& asked) -> Result<Answer> {
    const double f = asked.pixels.cols / 600.0;
    Answer answer;
    for (const Ball& ball : photographs[0].balls)
      answer.circles.push_back({{f * (ball.x + 2.5) - 0.5, f * (ball.y + 0.5) - 0.5, f * (ball.d + 4.0)}});
    return answer;
  };
  Asked asked;
  for (const Alteration& each : alterations())
    if (each.name == "x1.25") asked.alterations.push_back(&each);
  const auto outcomes = evaluated(photographs, finder, asked);
  DOUBLES_EQUAL(2.0, rms(outcomes->at(0).score.centre_px), 1e-9);
  DOUBLES_EQUAL(4.0, rms(outcomes->at(0).score.diameter_px), 1e-9);
}

TEST(RealEvaluation, TurnsNoCurvedPathAndNoBounceUpsideDown) {
  const TemporaryFolder folder;
  for (bool Photograph::*const field : {&Photograph::curved, &Photograph::bounces}) {
    auto photographs = collection(folder);
    photographs[0].*field = true;
    const auto outcomes = evaluated(photographs, blob_finders().front().find, all_alterations());
    LONGS_EQUAL(alterations().size() - 1, outcomes->size());
    for (const Outcome& outcome : *outcomes) CHECK(outcome.alteration->name != "upside-down");
  }
}

TEST(RealEvaluation, NamesThePhotographThatCannotBeRead) {
  const TemporaryFolder folder;
  strobe::testing::write_text(folder / "a.png", "no picture");
  const std::vector<Photograph> photographs{
      {"a.png", folder / "a.png", 0.03, 2000.0, {}, {}, false, false, {}}};
  const auto outcomes = evaluated(photographs, blob_finders().front().find, all_alterations());
  CHECK_FALSE(outcomes.has_value());
  STRCMP_CONTAINS("a.png: ", outcomes.error().message.c_str());
}

TEST(RealEvaluation, ATableOfTheLeaderboardIsReplacedByItsName) {
  const std::string text = "a\n<!-- leaderboard: one -->\nold\n<!-- end of leaderboard -->\nb\n";
  CHECK_EQUAL("a\n<!-- leaderboard: one -->\nnew\n<!-- end of leaderboard -->\nb\n",
              *with_leaderboard(text, "one", "new\n"));
  CHECK_EQUAL("has no leaderboard \"two\"", with_leaderboard(text, "two", "new\n").error().message);
}
