#include <sys/inotify.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <string>

#include "sim/loading/load_scene.hpp"
#include "sim/photograph/appearance.hpp"
#include "sim/photograph/board.hpp"
#include "sim/photograph/render.hpp"
#include "sim/rig/camera.hpp"
#include "sim/shoot/shoot.hpp"
#include "tests/support/pictures.hpp"
#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::sim;
namespace fs = std::filesystem;

namespace {

/// A small sensor, no noise, no irregular outline, shadows cast far aside.
Scene clean_scene(const std::string& camera = "") {
  auto scene = parse_scene(
      "[machine]\nspeed_mps = 17\nangle_deg = -23\nspin_radps = 100\n"
      "[bounce]\ne = 0.8\nmu = 0.6\ndwell_ms = 5\n"
      "[photograph]\nbits = 16\nread_noise_e = 0\nvignetting = 0\nflash_power_sd = 0\n"
      "[ball_appearance]\nsurface = \"plain\"\nline_tilt_deg = 0\n"
      "[background]\nwall = 0.5\nwall_distance_m = 20\nclutter = 0\nplate = false\n"
      "[camera]\npx_per_m = 1000\norigin_x_px = 375\norigin_y_px = 75\n" +
          camera,
      "clean.toml");
  if (!scene) FAIL(scene.error().message.c_str());
  scene->photograph.full_well_e = 1e30;
  return *scene;
}

/// The exposure with none but the flash of one pulse.
Exposure only(Exposure exposure, std::size_t pulse) {
  for (std::size_t i = 0; i < exposure.pulses.size(); ++i)
    if (i != pulse) exposure.pulses[i].flashes = {};
  return exposure;
}

Exposure rendered_shot(const Scene& scene) {
  auto shot = shoot(scene, 7, 1);
  if (!shot) FAIL(shot.error().message.c_str());
  return shot->exposure;
}

Photograph rendered(const Scene& scene, const Exposure& exposure, const Appearance& appearance) {
  auto photograph = render(scene, exposure, appearance);
  if (!photograph) FAIL(photograph.error().message.c_str());
  return *photograph;
}

struct Moments {
  double sum = 0.0, x = 0.0, y = 0.0, angle_rad = 0.0;
};

/// Of weights; y upwards.
template <typename Weight>
Moments moments(int width, int height, Weight weight) {
  double m = 0, mx = 0, my = 0, mxx = 0, mxy = 0, myy = 0;
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const double w = weight(column, row), y = height - 1.0 - row;
      m += w, mx += w * column, my += w * y;
      mxx += w * column * column, mxy += w * column * y, myy += w * y * y;
    }
  }
  const double x = mx / m, y = my / m;
  return {m, x, y, 0.5 * std::atan2(2.0 * (mxy / m - x * y), mxx / m - x * x - (myy / m - y * y))};
}

/// How much of each pixel the ball covers: a lighter wall shows everywhere but there.
Moments coverage(const Scene& scene, const Exposure& exposure, const Appearance& appearance) {
  Appearance light = appearance;
  light.background.wall = 0.1;
  const cv::Mat dark_wall = rendered(scene, exposure, light).pixels;
  light.background.wall = 0.9;
  const cv::Mat bright_wall = rendered(scene, exposure, light).pixels;
  Exposure empty = exposure;
  empty.ball.reset();
  const cv::Mat bright = rendered(scene, empty, light).pixels;
  light.background.wall = 0.1;
  const cv::Mat dark = rendered(scene, empty, light).pixels;
  return moments(dark.cols, dark.rows, [&](int column, int row) {
    const auto number = [&](const cv::Mat& m) {
      return static_cast<double>(m.at<std::uint16_t>(row, column));
    };
    return 1.0 - (number(bright_wall) - number(dark_wall)) / (number(bright) - number(dark));
  });
}

/// Looks at one image in the air, whole on the sensor.
void check_coverage(const Scene& scene) {
  const Exposure all = rendered_shot(scene);
  const Appearance appearance = draw_appearance(scene, 1, 1);
  const PhotographTruth truth = rendered(scene, all, appearance).truth;
  int looked_at = 0;
  for (const ImageTruth& image : truth.images) {
    if (!image.whole || image.contact_width_px || looked_at == 3) continue;
    ++looked_at;
    const Moments m = coverage(scene, only(all, static_cast<std::size_t>(image.flash_index)), appearance);
    // 2^-16 of a number's range in the quotient of two differences of 20000 and more: 1e-4 a pixel at random,
    // .005 px² over 4000 pixels; soft edges of 4 x 4 rays are exact for straight ones.
    DOUBLES_EQUAL(image.diameter_px, 2.0 * std::sqrt(m.sum / M_PI), 0.01);
    DOUBLES_EQUAL(image.centre_px.x, m.x, 0.01);
    DOUBLES_EQUAL(image.centre_px.y, m.y, 0.01);
  }
  LONGS_EQUAL(3, looked_at);
}

/// All numbers of the type, in an order that no compression shortens.
cv::Mat numbers(int type, int step) {
  cv::Mat pixels(40, 60, type);
  for (int row = 0; row < pixels.rows; ++row) {
    for (int column = 0; column < pixels.cols; ++column) {
      const int number = (row * pixels.cols + column) * step;
      if (type == CV_8UC1)
        pixels.at<std::uint8_t>(row, column) = static_cast<std::uint8_t>(number);
      else
        pixels.at<std::uint16_t>(row, column) = static_cast<std::uint16_t>(number);
    }
  }
  return pixels;
}

/// What the kernel tells of a folder's files, as "name:what " in the order that it happened.
class FolderEar {
 public:
  explicit FolderEar(const fs::path& folder) : descriptor_(inotify_init1(IN_NONBLOCK)) {
    inotify_add_watch(descriptor_, folder.c_str(),
                      IN_CREATE | IN_CLOSE_WRITE | IN_MOVED_FROM | IN_MOVED_TO | IN_DELETE);
  }
  FolderEar(const FolderEar&) = delete;
  FolderEar& operator=(const FolderEar&) = delete;
  ~FolderEar() { close(descriptor_); }

  std::string heard() {
    alignas(inotify_event) std::array<char, 8192> buffer{};
    const ssize_t size = read(descriptor_, buffer.data(), buffer.size());
    std::string text;
    for (ssize_t at = 0; at < size;) {
      const auto* event = reinterpret_cast<const inotify_event*>(buffer.data() + at);
      text += std::string(event->name) + ":" + word(event->mask) + " ";
      at += static_cast<ssize_t>(sizeof(inotify_event)) + event->len;
    }
    return text;
  }

 private:
  static const char* word(std::uint32_t mask) {
    if ((mask & IN_CREATE) != 0) return "created";
    if ((mask & IN_CLOSE_WRITE) != 0) return "closed";
    if ((mask & IN_MOVED_FROM) != 0) return "from";
    if ((mask & IN_MOVED_TO) != 0) return "to";
    return "deleted";
  }
  int descriptor_;
};

}  // namespace

TEST_GROUP(Render){};

TEST(Render, CoversTheDiscThatTheTruthTellsOf) { check_coverage(clean_scene()); }

TEST(Render, CoversTheEllipseOfABallSeenObliquely) {
  check_coverage(clean_scene("distance_m = 1.0\noff_plane_sd_mm = 10\n"));
}

TEST(Render, TellsTheMeanOfAFlashAndItsSecondDischarge) {
  Scene scene = clean_scene();
  scene.photograph.second_flash = 0.3;  // .15 px of the way in 30 us
  check_coverage(scene);
}

TEST(Render, SeesAnImageFromTheOtherSide) { check_coverage(clean_scene("mirrored = true\n")); }

TEST(Render, TurnsTheLineAsTheTruthTells) {
  for (const double tilt_rad : {0.0, 0.08}) {
    const Scene scene = clean_scene();
    const Exposure all = rendered_shot(scene);
    Appearance appearance = draw_appearance(scene, 1, 1);
    appearance.ball.line_tilt_rad = tilt_rad;
    appearance.ball.falloff = 1e-9;  // even light
    const PhotographTruth truth = rendered(scene, all, appearance).truth;
    const ImageTruth& image = truth.images[3];
    const Exposure one = only(all, static_cast<std::size_t>(image.flash_index));
    appearance.ball.line = false;
    const cv::Mat without = rendered(scene, one, appearance).pixels;
    appearance.ball.line = true;
    const cv::Mat with = rendered(scene, one, appearance).pixels;
    const Moments m = moments(with.cols, with.rows, [&](int column, int row) {
      return static_cast<double>(without.at<std::uint16_t>(row, column)) -
             with.at<std::uint16_t>(row, column);
    });
    // Lamps at two sides light the line's ends unevenly, which leans a half ellipse a little.
    DOUBLES_EQUAL(0.0, std::remainder(m.angle_rad - image.equator_rad, M_PI), tilt_rad > 0.0 ? 0.01 : 0.002);
  }
}

TEST(Render, CutsABallInContactOffAtTheSurface) {
  Scene scene = clean_scene("roll_deg = 0\n");
  const Exposure all = rendered_shot(scene);
  const Appearance appearance = draw_appearance(scene, 1, 1);
  const PhotographTruth truth = rendered(scene, all, appearance).truth;
  int contacts = 0;
  for (const ImageTruth& image : truth.images) {
    if (!image.contact_width_px) continue;
    ++contacts;
    const double radius = 0.5 * image.diameter_px;
    const double over = image.centre_px.y - truth.surface_px[0].y;
    // A circle less the segment below the surface.
    const double half_angle = std::acos(over / radius);
    const double area = radius * radius * (M_PI - half_angle + std::sin(half_angle) * std::cos(half_angle));
    const Moments m = coverage(scene, only(all, static_cast<std::size_t>(image.flash_index)), appearance);
    DOUBLES_EQUAL(area, m.sum, 0.02 * radius);
    DOUBLES_EQUAL(2.0 * radius * std::sin(half_angle), *image.contact_width_px, 1e-6);
    DOUBLES_EQUAL(image.centre_px.y + radius, image.top_px.y, 1e-9);
  }
  CHECK(contacts >= 1);
}

TEST(Render, AddsUpTheLightOfItsFlashes) {
  Scene scene = clean_scene();
  scene.photograph.black_level = 0.0;
  scene.photograph.exposure = 0.5;
  Appearance appearance = draw_appearance(scene, 1, 1);
  appearance.background.wall = 0.0;
  const Exposure all = rendered_shot(scene);
  const Photograph together = rendered(scene, all, appearance);
  cv::Mat sum = cv::Mat::zeros(together.pixels.size(), CV_32SC1);
  for (const ImageTruth& image : together.truth.images) {
    cv::Mat numbers;
    rendered(scene, only(all, static_cast<std::size_t>(image.flash_index)), appearance)
        .pixels.convertTo(numbers, CV_32S);
    sum += numbers;
  }
  cv::Mat numbers;
  together.pixels.convertTo(numbers, CV_32S);
  // Half a number's rounding for each image, and for the whole.
  CHECK(cv::norm(sum, numbers, cv::NORM_INF) <=
        0.5 * static_cast<double>(together.truth.images.size()) + 1.0);
}

TEST(Render, HasTheNoiseThatTheSceneSays) {
  Scene scene = clean_scene();
  scene.photograph.full_well_e = 2000.0;
  scene.photograph.read_noise_e = 20.0;
  scene.photograph.black_level = 0.1;
  scene.photograph.ambient = 0.2;
  Exposure dark = rendered_shot(scene);
  for (Pulse& pulse : dark.pulses) pulse.flashes = {};
  const cv::Mat pixels = rendered(scene, dark, draw_appearance(scene, 1, 1)).pixels;
  cv::Scalar mean, sd;
  cv::meanStdDev(pixels, mean, sd);
  // 330000 pixels: the sd's own sd is .12 %, five of which and what the normal's table leaves out.
  const double expected = std::sqrt(0.2 / 2000.0 + 20.0 * 20.0 / (2000.0 * 2000.0));
  DOUBLES_EQUAL(0.3, mean[0] / 65535.0, 1e-4);
  DOUBLES_EQUAL(expected, sd[0] / 65535.0, 0.01 * expected);
}

TEST(Render, IsRepeatedBySeedAndDiffersByShot) {
  Scene scene = clean_scene();
  scene.photograph.bits = 8;
  scene.photograph.full_well_e = 5000.0;
  const Exposure exposure = rendered_shot(scene);
  const cv::Mat first = rendered(scene, exposure, draw_appearance(scene, 5, 1)).pixels;
  LONGS_EQUAL(CV_8UC1, first.type());
  CHECK_EQUAL(0.0,
              cv::norm(first, rendered(scene, exposure, draw_appearance(scene, 5, 1)).pixels, cv::NORM_INF));
  CHECK(cv::norm(first, rendered(scene, exposure, draw_appearance(scene, 5, 2)).pixels, cv::NORM_INF) > 0.0);
}

TEST_GROUP(Optics){};

TEST(Optics, SeesPointsWhereTheCameraDoesAndFindsThemBack) {
  const Scene scene = clean_scene("distance_m = 0.9\ndistortion = -0.12\nroll_deg = 3\nmirrored = true\n");
  const Optics optics(scene);
  const Camera camera(scene);
  for (const double x_m : {-0.3, 0.02, 0.25}) {
    for (const double y_m : {0.0, 0.1, 0.35}) {
      const auto expected = camera.project(x_m, y_m, 0.03);
      const Vec2 seen = optics.image_of(optics.from_surface(x_m, y_m, 0.03));
      DOUBLES_EQUAL(expected.x, seen.x, 1e-9);
      DOUBLES_EQUAL(expected.y, optics.sensor().height - 1.0 - seen.y, 1e-9);
      const Vec3 in_plane = optics.from_surface(x_m, y_m, 0.0);
      const Vec2 image = optics.image_of(in_plane);
      const Vec2 back = optics.plane_at(image.x, image.y);
      DOUBLES_EQUAL(in_plane.x, back.x, 1e-9);
      DOUBLES_EQUAL(in_plane.y, back.y, 1e-9);
    }
  }
}

TEST(Render, AddsTheLightOfEachFlashToASteadyBackground) {
  Scene scene = clean_scene();
  scene.photograph.steady = true;
  scene.background.flashes = 100;
  Exposure exposure = rendered_shot(scene);
  exposure.ball.reset();
  Exposure half = exposure;
  for (std::size_t i = 0; i < half.pulses.size(); i += 2)
    half.pulses[i].flashes = {}, half.pulses[i].lamps = {};
  const auto mean = [&](const Exposure& of, int shot) {
    const auto photograph = render(scene, of, draw_appearance(scene, 1, shot));
    if (!photograph) FAIL(photograph.error().message.c_str());
    return cv::mean(photograph->pixels)[0] / 65535.0 - scene.photograph.black_level;
  };
  // A number is within 2^-17 of the light, and the light is some .02.
  const double share =
      static_cast<double>(exposure.pulses.size() / 2) / static_cast<double>(exposure.pulses.size());
  DOUBLES_EQUAL(share, mean(half, 1) / mean(exposure, 1), 1e-3);
  DOUBLES_EQUAL(1.0, mean(exposure, 2) / mean(exposure, 1), 1e-3);
  scene.photograph.steady = false;
  CHECK(std::abs(mean(exposure, 2) / mean(exposure, 1) - 1.0) > 1e-3);
}

TEST(Render, ShowsTheSecondBallOfADoubleThrow) {
  const Scene scene = clean_scene();
  Exposure exposure = rendered_shot(scene);
  const cv::Mat one = rendered(scene, exposure, draw_appearance(scene, 1, 1)).pixels;
  exposure.more_balls.push_back({exposure.ball->path, exposure.ball->touchdown + milliseconds(1)});
  const Photograph two = rendered(scene, exposure, draw_appearance(scene, 1, 1));
  CHECK(cv::mean(two.pixels)[0] > cv::mean(one)[0]);
  CHECK(rendered_shot(scene).pulses.size() >= two.truth.images.size());
}

// By xenon light a sensor's red and blue pixels have .5 and .67 of the light of its green ones, which have a grey
// sensor's; felt reflects .62, .80 and .22 of the three. Rounding is a thousandth of such sums.
TEST(Render, ShowsAYellowBallInAMosaic) {
  Scene scene = clean_scene();
  scene.photograph.bits = 14;
  scene.ball_appearance.surface = BallSurface::felt;
  scene.background.wall = 0.0;
  const Exposure exposure = rendered_shot(scene);
  const Photograph grey = rendered(scene, exposure, draw_appearance(scene, 1, 1));
  scene.photograph.format = PhotographFormat::mosaic;
  const Photograph photograph = rendered(scene, exposure, draw_appearance(scene, 1, 1));
  CHECK(photograph.mosaic.has_value() && !grey.mosaic.has_value());
  LONGS_EQUAL(16383, photograph.mosaic->white);
  const double black = photograph.mosaic->black;
  const auto light = [&](const cv::Mat& pixels, const cv::Rect& place, int column, int row) {
    double sum = 0.0;
    for (int y = place.y / 2 * 2 + row; y < place.y + place.height; y += 2)
      for (int x = place.x / 2 * 2 + column; x < place.x + place.width; x += 2)
        sum += pixels.at<std::uint16_t>(y, x) - black;
    return sum;
  };
  const auto& ball = *std::ranges::find_if(photograph.truth.images, [](const ImageTruth& image) {
    return image.whole && image.leg != strobe::reduction::Leg::contact;
  });
  const int x = cvRound(ball.centre_px.x), y = grey.pixels.rows - 1 - cvRound(ball.centre_px.y);
  const int reach = cvRound(0.3 * ball.diameter_px);
  const cv::Rect place(x - reach, y - reach, 2 * reach, 2 * reach);
  const auto share = [&](int column, int row) {
    return light(photograph.pixels, place, column, row) / light(grey.pixels, place, column, row);
  };
  DOUBLES_EQUAL(1.0, share(1, 0), 0.002);
  DOUBLES_EQUAL(1.0, share(0, 1), 0.002);
  DOUBLES_EQUAL(0.5 * 0.62 / 0.80, share(0, 0), 0.002);
  DOUBLES_EQUAL(0.67 * 0.22 / 0.80, share(1, 1), 0.002);
}

TEST_GROUP(PhotographFile) { strobe::testing::TemporaryFolder folder; };

TEST(PhotographFile, KeepsEveryNumber) {
  for (const auto& [type, step] : {std::pair{CV_8UC1, 1}, std::pair{CV_16UC1, 27}}) {
    for (const PhotographFormat format : {PhotographFormat::tiff, PhotographFormat::png}) {
      const cv::Mat pixels = numbers(type, step);
      const fs::path path = folder / ("a" + extension(format));
      CHECK_TRUE(write_photograph(path, pixels, format).has_value());
      const cv::Mat read = strobe::testing::read_picture(path);
      LONGS_EQUAL(type, read.type());
      CHECK_EQUAL(0.0, cv::norm(pixels, read, cv::NORM_INF));
    }
  }
}

TEST(PhotographFile, IsAsLargeAsItsPixelsWhereItIsNotCompressed) {
  const fs::path path = folder / "a.tif";
  CHECK_TRUE(write_photograph(path, cv::Mat::zeros(40, 60, CV_16UC1), PhotographFormat::tiff).has_value());
  CHECK(fs::file_size(path) >= 40 * 60 * 2);
}

TEST(PhotographFile, AppearsUnderItsNameOnlyWhenItIsWhole) {
  FolderEar ear(folder.path());
  CHECK_TRUE(write_photograph(folder / "a.tif", numbers(CV_8UC1, 1), PhotographFormat::tiff).has_value());
  CHECK_EQUAL("a.tif.part:created a.tif.part:closed a.tif.part:from a.tif:to ", ear.heard());
}

TEST(PhotographFile, BearsTheTimeThatItIsGivenBeforeItAppears) {
  const strobe::WallTime written{std::chrono::sys_days{std::chrono::year{2000} / 1 / 1}};
  const fs::path path = folder / "a.tif";
  CHECK_TRUE(write_photograph(path, numbers(CV_8UC1, 1), PhotographFormat::tiff, written).has_value());
  CHECK(std::chrono::file_clock::to_sys(fs::last_write_time(path)) == written);
}

TEST(PhotographFile, ThatCannotBeWrittenIsNamedAndLeavesNothing) {
  const auto absent = write_photograph(folder / "no/a.tif", numbers(CV_8UC1, 1), PhotographFormat::tiff);
  CHECK_FALSE(absent.has_value());
  STRCMP_CONTAINS("no/a.tif: cannot be written", absent.error().message.c_str());
  // A folder of that name cannot be replaced by a file.
  fs::create_directories(folder / "b.tif" / "full");
  const auto taken = write_photograph(folder / "b.tif", numbers(CV_8UC1, 1), PhotographFormat::tiff);
  CHECK_FALSE(taken.has_value());
  CHECK_FALSE(fs::exists(folder / "b.tif.part"));
  const auto empty = write_photograph(folder / "c.tif", cv::Mat(), PhotographFormat::tiff);
  CHECK_FALSE(empty.has_value());
  STRCMP_CONTAINS("c.tif: cannot be encoded", empty.error().message.c_str());
}

TEST_GROUP(BoardView) {
  const Board board{BoardPrint::chessboard, 9, 6, 0.03};

  /// The largest difference between two places' distances in the plane, by the board's camera and by the scene's.
  double worst_m(const std::string& name) const {
    const auto scene = load_scene(name);
    CHECK_TRUE(scene.has_value());
    return worst_m(*scene);
  }
  double worst_m(const Scene& scene) const {
    const Optics optics(scene);
    const BoardView view = board_view(scene);
    double worst = 0.0;
    for (const double row : {0.1, 0.5, 0.9}) {
      for (const double column : {0.1, 0.4, 0.9}) {
        const double x = column * view.camera.width_px, y = row * view.camera.height_px;
        const double x0 = 0.5 * view.camera.width_px, y0 = 0.5 * view.camera.height_px;
        const Vec2 here = optics.plane_at(x, y), middle = optics.plane_at(x0, y0);
        const cv::Point2d there = board_at(view.camera, board, view.place, {x, y}) -
                                  board_at(view.camera, board, view.place, {x0, y0});
        worst = std::max(worst, std::abs(std::hypot(here.x - middle.x, here.y - middle.y) - cv::norm(there)));
      }
    }
    return worst;
  }
};

// 1e-9 m is some millionth of a px; the inverse of the distortion is found to 1e-10 or better by either camera.
TEST(BoardView, PlaneIsAsLargeAsTheScenesCameraSeesIt) {
  for (const char* name : {"zero_23", "photo_tilted", "photo_close_lens", "photo_small"})
    CHECK_TEXT(worst_m(name) < 1e-9, name);
}

TEST(BoardView, IsATurnedCamerasAsWell) {
  auto scene = load_scene("photo_close_lens");
  scene->camera.distortion = 0.0;
  scene->camera.swing_rad = 0.05;
  scene->camera.tilt_rad = -0.03;
  CHECK(worst_m(*scene) < 1e-9);
}

TEST(BoardView, BoardIsInTheMiddleOfThePhotograph) {
  const auto scene = load_scene("photo_small");
  const BoardView view = board_view(*scene);
  const cv::Point2d corner = image_of(view.camera, board, view.place, {0.0, 0.0});
  const cv::Point2d opposite = image_of(view.camera, board, view.place, {8 * 0.03, 5 * 0.03});
  // Within a px: the lens is 100 m away and bends nothing.
  DOUBLES_EQUAL(0.5 * (view.camera.width_px - 1), 0.5 * (corner.x + opposite.x), 1.0);
  DOUBLES_EQUAL(0.5 * (view.camera.height_px - 1), 0.5 * (corner.y + opposite.y), 1.0);
}
