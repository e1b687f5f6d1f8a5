#include "tests/host/web/painted_session.hpp"

#include <fmt/format.h>

#include <cmath>
#include <random>
#include <strobe_msgs/frame_t.hpp>

#include "tests/host/digitize/painter.hpp"
#include "tests/support/pictures.hpp"

namespace strobe::web_test {
namespace {

namespace fs = std::filesystem;
using host_test::WrittenRun;

constexpr double kShrink = kPxPerM / 4000.0;  // of the synthetic frames

/// The frame in the photograph's px, without noise.
strobe_msgs::frame_t frame_of(int shot_id) {
  host_test::Scenario scenario;
  scenario.seed = 1;  // that of WrittenRun::summary()
  scenario.noise_mm = 0.0;
  scenario.equator_noise_rad = 0.0;
  auto frame = host_test::make_shot(scenario).frame;
  frame.boot_id = WrittenRun::kBoot;
  frame.shot_id = shot_id;
  frame.source = "auto";
  frame.px_per_m = kPxPerM;
  frame.px_per_m_sd = 0.5;
  frame.centre_sd_px = frame.diameter_sd_px = 0.1;
  frame.surface_sd_px = 0.2;
  frame.equator_sd_rad = 0.003;
  const auto x = [](double px) { return (px - 2500.0) * kShrink + 0.5 * kWidth_px; };
  const auto y = [](double px) { return (px - 300.0) * kShrink + kHeight_px - 1 - kSurfaceRow_px; };
  for (auto& image : frame.images) {
    image.centre_x_px = x(image.centre_x_px);
    image.centre_y_px = y(image.centre_y_px);
    image.diameter_px = host_test::kBallDiameter_m * kPxPerM;
  }
  for (auto& point : frame.surface) {
    point.x_px = x(point.x_px);
    point.y_px = y(point.y_px);
  }
  return frame;
}

testing::Painting painting_of(const strobe_msgs::frame_t& frame) {
  testing::Painting painting;
  painting.width = kWidth_px;
  painting.height = kHeight_px;
  painting.bits = 16;
  painting.background = 0.04;
  painting.plate_row = kSurfaceRow_px + 0.5;
  painting.plate = 0.5;
  std::mt19937_64 random(11);
  testing::PaintedBall look = testing::random_ball(random, {}, host_test::kBallDiameter_m * kPxPerM);
  look.light = 0.15;
  for (const auto& image : frame.images) {
    look = testing::next_image(look, {image.centre_x_px, kHeight_px - 1 - image.centre_y_px}, 0.0);
    if (look.line) look.line->angle_rad = image.equator_rad;
    look.floor_row = kSurfaceRow_px;
    painting.balls.push_back(look);
  }
  return painting;
}

}  // namespace

std::string painted_rig() {
  return fmt::format("rig = \"bench\"\n[machine]\nlag_ms = 310\n[camera]\npx_per_m = {}\npx_per_m_sd = 0.5\n",
                     kPxPerM);
}

void add_painted_shot(WrittenRun& run, const fs::path& session, int shot_id) {
  strobe_msgs::frame_t frame = frame_of(shot_id);
  frame.host_id = run.host_id();
  frame.photograph = fmt::format("photographs/shot-{:04}-painted.tif", shot_id);
  fs::create_directories(session / "photographs");
  const auto photograph = testing::paint(painting_of(frame));
  cv::Mat pixels;
  photograph.intensity.convertTo(pixels, CV_16U, 65535.0);
  testing::write_picture(session / frame.photograph, pixels);
  run.heartbeat();
  run.arm_and_fire();
  run.started(shot_id);
  run.flash(shot_id);
  run.ended(shot_id);
  run.summary(shot_id);
  run.log(messages::Channel::frame, frame);
}

std::string image_place(int image, int shot_id) {
  const auto frame = frame_of(shot_id);
  const auto& at = frame.images.at(static_cast<std::size_t>(image));
  return fmt::format("[{:.1f}, {:.1f}]", at.centre_x_px, kHeight_px - 1 - at.centre_y_px);
}

}  // namespace strobe::web_test
