// Each alteration, tried on a disc: where its truth goes is where the disc's light goes.
#include "tests/real/alterations.hpp"

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>

#include "tests/support/string_from.hpp"

using namespace strobe::real;

namespace {

constexpr double kDark = 20.0, kBright = 200.0;  // of 255
const cv::Size kSize(400, 300);
constexpr double kX = 230.3, kY = 120.6, kD = 100.0;

/// A disc whose edge pixels are as bright as the part that it covers, by 8 x 8 places in each.
cv::Mat disc(int type) {
  cv::Mat light(kSize, CV_32F, cv::Scalar(kDark));
  for (int y = 0; y < kSize.height; ++y)
    for (int x = 0; x < kSize.width; ++x) {
      int covered = 0;
      for (int k = 0; k < 64; ++k)
        covered += std::hypot(x + (k % 8 - 3.5) / 8 - kX, y + (k / 8 - 3.5) / 8 - kY) <= 0.5 * kD;
      light.at<float>(y, x) += static_cast<float>((kBright - kDark) * covered / 64.0);
    }
  cv::Mat one, pixels;
  light.convertTo(one, CV_MAT_DEPTH(type), CV_MAT_DEPTH(type) == CV_16U ? 257.0 : 1.0);
  cv::merge(std::vector<cv::Mat>(static_cast<std::size_t>(CV_MAT_CN(type)), one), pixels);
  return pixels;
}

/// By the light above the background, of what is brighter, in a window about the place where it should be.
Circle seen_disc(const cv::Mat& pixels, const Circle& near) {
  cv::Mat light;
  cv::extractChannel(pixels, light, 0);
  light.convertTo(light, CV_64F);
  const double dark = light.at<double>(light.rows - 30, 30),
               bright = light.at<double>(cv::Point(cvRound(near.x), cvRound(near.y)));
  double sum = 0.0, sx = 0.0, sy = 0.0;
  const double reach = 0.5 * near.d + 6.0;
  for (int y = 0; y < light.rows; ++y)
    for (int x = 0; x < light.cols; ++x) {
      if (std::hypot(x - near.x, y - near.y) > reach) continue;
      const double above = light.at<double>(y, x) - dark;
      sum += above, sx += above * x, sy += above * y;
    }
  return {sx / sum, sy / sum, std::sqrt(4.0 / CV_PI * sum / (bright - dark))};
}

Photograph photograph() {
  Photograph p;
  p.px_per_m = 2000.0;
  p.ball_diameter_m = 0.05;
  p.balls = {{{kX, kY, kD}, Kind::ball}};
  p.ghost_path = {{kX, kY}, {kX + 10, kY}};
  return p;
}

const Alteration& alteration(const std::string& name) {
  for (const Alteration& each : alterations())
    if (each.name == name) return each;
  FAIL(name.c_str());
  return alterations().front();
}

}  // namespace

TEST_GROUP(RealAlterations){};

// Noise of 4 in 255 under a contrast of 180 moves the centroid by .008 px, and so does each of the two hot
// pixels that the window may hold; gamma makes the disc .2 px wider; noise at the one pixel whose brightness
// is taken for the disc's makes the diameter 2 % of contrast, 1.1 px, wrong. A wrong half pixel would show as
// .1 px at the scales tried, a truth that is not moved as 3 px and more, a wrong scale of 1 % as 1 px where
// there is no noise.
TEST(RealAlterations, TheTruthGoesWhereTheLightGoes) {
  for (const int type : {CV_8UC1, CV_8UC3, CV_16UC1}) {
    const cv::Mat before = disc(type);
    for (const Alteration& each : alterations()) {
      const Altered after = each.make(before);
      const std::string name(each.name);
      CHECK_TEXT(after.pixels.type() == type, name.c_str());
      const Photograph truth = altered_truth(photograph(), after, before.size());
      const Ball& ball = truth.balls[0];
      const Circle seen = seen_disc(after.pixels, ball);
      DOUBLES_EQUAL_TEXT(ball.x, seen.x, 0.05, name.c_str());
      DOUBLES_EQUAL_TEXT(ball.y, seen.y, 0.05, name.c_str());
      DOUBLES_EQUAL_TEXT(ball.d, seen.d, name == "noise-4" ? 3.0 : 0.5, name.c_str());
      DOUBLES_EQUAL_TEXT(truth.px_per_m * truth.ball_diameter_m, ball.d, 1e-9, name.c_str());
      DOUBLES_EQUAL_TEXT(ball.x, truth.ghost_path[0].x, 1e-9, name.c_str());
      DOUBLES_EQUAL_TEXT(10.0 * after.scale,
                         std::hypot(truth.ghost_path[1].x - ball.x, truth.ghost_path[1].y - ball.y), 0.02,
                         name.c_str());
    }
  }
}

TEST(RealAlterations, EachButTheFirstChangesAColouredPicture) {
  cv::Mat before = disc(CV_8UC3);
  before.forEach<cv::Vec3b>([](cv::Vec3b& pixel, const int*) { pixel[0] = 10; });
  for (const Alteration& each : alterations()) {
    const Altered after = each.make(before);
    const bool is_same =
        after.pixels.size() == before.size() && cv::norm(after.pixels, before, cv::NORM_INF) == 0.0;
    CHECK_TEXT(is_same == (&each == &alterations().front()), std::string(each.name).c_str());
  }
}

TEST(RealAlterations, AreTheSameEachTime) {
  const cv::Mat before = disc(CV_8UC1);
  for (const char* name : {"noise-4", "hot-pixels"})
    CHECK(cv::norm(alteration(name).make(before).pixels, alteration(name).make(before).pixels,
                   cv::NORM_INF) == 0.0);
}

TEST(RealAlterations, ABallThatIsCutIsAskedForNoMore) {
  const cv::Mat before = disc(CV_8UC1);
  Photograph p = photograph();
  p.balls.push_back({{55.0, 150.0, 100.0}, Kind::ball});  // 5.5 px from the left, of which 11 go
  p.balls.push_back({{45.0, 150.0, 100.0}, Kind::ball});  // cut before, but must be found
  const Photograph truth = altered_truth(p, alteration("cropped").make(before), before.size());
  CHECK(truth.balls[0].kind == Kind::ball);
  CHECK(truth.balls[1].kind == Kind::optional);
  CHECK(truth.balls[2].kind == Kind::ball);
  p.balls[2] = {{10.0, 150.0, 22.0}, Kind::ball};  // half a px over the border, and 11 of 22 more
  CHECK(altered_truth(p, alteration("cropped").make(before), before.size()).balls[2].kind == Kind::optional);
}
