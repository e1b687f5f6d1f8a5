// What counts as found, missed, invented, a ghost and a double.
#include "tests/real/judge.hpp"

#include <cmath>

#include "tests/support/string_from.hpp"

using namespace strobe::real;

namespace {

Ball ball(double x, double y, Kind kind = Kind::ball) { return {{x, y, 100.0}, kind}; }
Found image(double x, double y, double d = 100.0) { return {{x, y, d}}; }

Photograph of(std::vector<Ball> balls) {
  Photograph photograph;
  photograph.ball_diameter_m = 0.05;
  photograph.px_per_m = 2000.0;  // 100 px
  photograph.balls = std::move(balls);
  return photograph;
}

void check_counts(const Score& s, int found, int invented, int ghosts, int doubles) {
  LONGS_EQUAL(found, s.found);
  LONGS_EQUAL(invented, s.invented);
  LONGS_EQUAL(ghosts, s.ghosts);
  LONGS_EQUAL(doubles, s.doubles);
  LONGS_EQUAL(invented + ghosts + doubles, s.strays.size());
}

}  // namespace

TEST_GROUP(RealJudge){};

TEST(RealJudge, FindsWhatIsWithinAQuarterOfTheDiameter) {
  const Score s = judged(of({ball(0, 0), ball(500, 0), ball(900, 0)}),
                         {image(3, 4, 101), image(524.9, 0), image(925.1, 0)});
  LONGS_EQUAL(3, s.balls);
  check_counts(s, 2, 0, 0, 1);  // the last one lies within its ball, but is not its image
  DOUBLES_EQUAL(5.0, s.centre_px[0], 1e-12);
  DOUBLES_EQUAL(1.0, s.diameter_px[0], 1e-12);
  LONGS_EQUAL(1, s.missed.size());
  DOUBLES_EQUAL(900, s.missed[0].x, 0.0);
}

TEST(RealJudge, GivesEachBallTheNearestImageAndNoImageTwice) {
  // By the order in which they come the first ball would take the first image, and leave none to the second.
  const Score two = judged(of({ball(0, 0), ball(40, 0)}), {image(20, 0), image(-5, 0)});
  check_counts(two, 2, 0, 0, 0);
  const Score one = judged(of({ball(0, 0), ball(40, 0)}), {image(20, 0)});
  LONGS_EQUAL(1, one.found);
  LONGS_EQUAL(1, one.missed.size());
}

TEST(RealJudge, ASecondImageOfABallIsADoubleAndOneElsewhereInvented) {
  check_counts(judged(of({ball(0, 0)}), {image(1, 0), image(2, 0), image(51, 0), image(49, 0)}), 1, 1, 0, 2);
}

TEST(RealJudge, OptionalBallsCountNeitherWay) {
  const Photograph photograph = of({ball(0, 0, Kind::optional)});
  check_counts(judged(photograph, {image(0, 0)}), 0, 0, 0, 0);
  LONGS_EQUAL(0, judged(photograph, {}).balls);
  check_counts(judged(photograph, {image(0, 0), image(5, 0)}), 0, 0, 0, 1);
  check_counts(judged(photograph, {image(30, 0)}), 0, 0, 0, 0);  // badly measured, but all that there is of it
}

TEST(RealJudge, WhatLiesOnAGhostOrAlongAGhostPathIsAGhost) {
  Photograph photograph = of({ball(0, 0), ball(300, 0, Kind::ghost)});
  photograph.ghost_path = {{0, 500}, {400, 500}, {400, 900}};
  check_counts(judged(photograph, {image(0, 0), image(301, 0), image(345, 0)}), 1, 0, 2, 0);
  check_counts(judged(photograph, {image(200, 524), image(424, 700), image(400, 924)}), 0, 0, 3, 0);
  check_counts(judged(photograph, {image(200, 526), image(426, 700), image(400, 926)}), 0, 3, 0, 0);
}

TEST(RealJudge, ABallOnAGhostPathMustBeFoundAllTheSame) {
  Photograph photograph = of({ball(200, 500)});
  photograph.ghost_path = {{0, 500}, {400, 500}};
  check_counts(judged(photograph, {image(200, 500)}), 1, 0, 0, 0);
  LONGS_EQUAL(1, judged(photograph, {}).missed.size());
}

TEST(RealJudge, AtAWrongScaleOnlyBallsOfThatSizeCount) {
  Photograph photograph = of({ball(0, 0), ball(500, 0)});
  photograph.balls[1].d = 112.0;
  // Told 110 px: 100 is 9.1 % off and 112 is 1.8 % off.
  LONGS_EQUAL(1, judged(photograph, {}, 1.1, 0.05).balls);
  LONGS_EQUAL(2, judged(photograph, {}, 1.1, 0.10).balls);
}

TEST(RealJudge, ErrorsAreInPixelsOfThePhotographBeforeItWasScaled) {
  const Score s = judged(of({ball(0, 0)}), {image(3, 4, 90)}, 1.0, 1e9, 0.5);
  DOUBLES_EQUAL(10.0, s.centre_px[0], 1e-12);
  DOUBLES_EQUAL(-20.0, s.diameter_px[0], 1e-12);
}

TEST(RealJudge, CountsTheBallsThatAreFoundOnlyOneWay) {
  const Photograph photograph = of({ball(0, 0), ball(300, 0), ball(600, 0)});
  const Score before = judged(photograph, {image(0, 0), image(300, 0)});
  LONGS_EQUAL(0, changed(before, before));
  LONGS_EQUAL(2, changed(before, judged(photograph, {image(0, 0), image(600, 0)})));
  Photograph cut = photograph;
  cut.balls[1].kind = Kind::optional;  // as of a crop: it is not asked for any more
  LONGS_EQUAL(0, changed(before, judged(cut, {image(0, 0)})));
}

TEST(RealJudge, ScoresOfPhotographsAddUp) {
  Photograph one = of({ball(0, 0)}), other = of({ball(0, 0), ball(300, 0)});
  one.path = "one";
  other.path = "other";
  Score sum = judged(one, {image(0, 3)});
  sum += judged(other, {image(0, 4), image(900, 0)});
  LONGS_EQUAL(2, sum.pictures);
  LONGS_EQUAL(3, sum.balls);
  check_counts(sum, 2, 1, 0, 0);
  DOUBLES_EQUAL(std::sqrt(12.5), rms(sum.centre_px), 1e-12);
  LONGS_EQUAL(3, sum.asked_names.size());
  DOUBLES_EQUAL(2.0 * 2 / (3 + 2 + 1), sum.f1(), 1e-12);
}

TEST(RealJudge, StatedSdsAreHeldAgainstTheErrorsWithTheAnnotationsNoiseInThem) {
  Found right = image(3, -4, 97), wrong = image(300, 0);
  right.sds = {1.0, 1.0, 1.0};
  wrong.sds = {1.0, 0.1, 1.0};
  const Photograph photograph = of({ball(0, 0), ball(303.1, 0.29)});
  const Score s = judged(photograph, {right, wrong, image(900, 0)});
  const Beyond alone = beyond_3_sd(s, {{0.0}, {0.0}, 0});
  LONGS_EQUAL(6, alone.of);
  LONGS_EQUAL(2, alone.count);  // -4 of 1, -3.1 of 1; the others are 3, -3, -0.29 of 0.1 and 0
  // Two annotations 2 px apart in the centre: 1 px a coordinate of one, so that 3 sds are 4.2 px.
  LONGS_EQUAL(0, beyond_3_sd(s, {{2.0}, {2.0}, 0}).count);
  // Scaled with its errors: the same.
  LONGS_EQUAL(2, beyond_3_sd(judged(photograph, {right, wrong}, 1.0, 1e9, 0.5), {{0.0}, {0.0}, 0}).count);
  LONGS_EQUAL(0, beyond_3_sd(judged(photograph, {image(3, -4)}), {{0.0}, {0.0}, 0}).of);
}

TEST(RealJudge, TwoAnnotationsDifferAsTheirCirclesDo) {
  Photograph twice = of({ball(0, 0), ball(300, 0), ball(600, 0, Kind::optional), ball(900, 0)});
  twice.second = {{{3, 4, 102}, Kind::ball},
                  {{300, 5, 98}, Kind::ball},
                  {{600, 9, 100}, Kind::optional},
                  {{1500, 0, 100}, Kind::ball}};
  const Agreement both = agreement({twice, of({ball(0, 0)})});
  LONGS_EQUAL(2, both.centre_px.size());
  DOUBLES_EQUAL(5.0, both.centre_rms_px(), 1e-12);
  DOUBLES_EQUAL(2.0, both.diameter_rms_px(), 1e-12);
  LONGS_EQUAL(2, both.only_one);
}
