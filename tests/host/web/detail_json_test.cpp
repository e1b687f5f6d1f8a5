#include "host/archive/shot_outcome.hpp"
#include "host/web/detail_json.hpp"

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "host/assembly/assemble.hpp"
#include "host/view/render.hpp"
#include "host/web/shot_json.hpp"
#include "tests/host/synthetic_shot.hpp"
#include "tests/host/web/documented.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using nlohmann::ordered_json;

host::Shot stored(const host_test::Scenario& scenario) {
  const auto made = host_test::make_shot(scenario);
  host::RigFile rig;
  rig.machine_lag_s = host_test::kMachineLag_s;
  host::Shot shot = measured_shot(made.shot, made.frame, {}, assembly_settings(rig));
  shot.rig = std::make_shared<const host::RigFile>(rig);
  shot.name = "3";
  shot.utc = "2026-01-31T09:30:00.000Z";
  shot.digitizations.back().utc = shot.utc;
  return shot;
}

const web::PhotographPlace kPhotograph{"/p", 2000, 1000};

}  // namespace

TEST_GROUP(DetailJson){};

TEST(DetailJson, TellsOfEachImageWhereItIsAndHowWellItFits) {
  const host::Shot shot = stored({});
  const ordered_json detail = web::detail_json(shot, "today", kPhotograph);
  const auto& frame = shot.digitizations.back().frame;
  LONGS_EQUAL(frame.images.size(), detail["images"].size());
  int used = 0;
  for (std::size_t i = 0; i < frame.images.size(); ++i) {
    const ordered_json& image = detail["images"][i];
    DOUBLES_EQUAL(frame.images[i].centre_x_px, image["centre_px"][0].get<double>(), 1e-9);
    DOUBLES_EQUAL(999.0 - frame.images[i].centre_y_px, image["centre_px"][1].get<double>(), 1e-9);
    LONGS_EQUAL(i + 1, image["index"].get<int>());
    const bool contact = image["leg"] == "contact";
    CHECK_EQUAL(!contact, image["used"].get<bool>());
    CHECK_EQUAL(contact, image["residual_px"].is_null());
    CHECK_EQUAL(contact, image["why_not"].is_string());
    if (contact) continue;
    ++used;
    // Noise of 0.2 mm: four sds of a point in the plane.
    const double px_per_mm = frame.images[i].diameter_px / 65.1;
    CHECK_TRUE(image["residual_px"].get<double>() < 4.0 * 0.2 * px_per_mm);
    CHECK_TRUE(image["flash_index"].is_number_integer());
  }
  CHECK_TRUE(used >= 8);
  CHECK_TRUE(detail["surface_px"].size() >= 2);
  CHECK_EQUAL("/p", detail["photograph"]["url"].get<std::string>());
  CHECK_TRUE(detail["budget"]["e"].is_array());
  LONGS_EQUAL(shot.train.planned, detail["train"]["planned"].get<int>());
  CHECK_FALSE(detail["train"]["dry"].get<bool>());
}

TEST(DetailJson, SaysWhyAnImageIsNotUsed) {
  host::Shot shot = stored({});
  auto& frame = shot.digitizations.back().frame;
  frame.images[1].centre_y_px += 25.0;
  frame.images[1].source = strobe_msgs::ball_image_t::SOURCE_AUTO, frame.images[1].probability = 0.629;
  host::judge_again(shot);
  CHECK_TRUE(shot.readout.flags.has(reduction::Flag::outlier_image));
  const ordered_json detail = web::detail_json(shot, "today", kPhotograph);
  CHECK_FALSE(detail["images"][1]["used"].get<bool>());
  const std::string why_not = detail["images"][1]["why_not"];
  STRCMP_CONTAINS("left out", why_not.c_str());
  STRCMP_CONTAINS("; the digitizer gives it 62 % of being a ball's", why_not.c_str());
  CHECK_TRUE(detail["images"][0]["used"].get<bool>());
  STRCMP_CONTAINS("move or remove it by hand", detail["advice"].get<std::string>().c_str());
  CHECK_TRUE(detail["flag_words"].size() >= 1);
}

TEST(DetailJson, OfAShotWithoutAPhotographHasNoImages) {
  host::Shot shot = stored({});
  shot.digitizations.clear();
  host::judge_again(shot);
  const ordered_json detail = web::detail_json(shot, "today", std::nullopt);
  LONGS_EQUAL(0, detail["images"].size());
  CHECK_TRUE(detail["photograph"].is_null());
  CHECK_TRUE(detail["surface_px"].is_null());
  DOUBLES_EQUAL(0.0651, detail["ball_diameter_m"].get<double>(), 0.0);
  CHECK_EQUAL("no photograph in the log", detail["problem"].get<std::string>());
  STRCMP_CONTAINS("camera", detail["advice"].get<std::string>().c_str());
}

TEST(DetailJson, OfPointsDigitizedElsewhereHasThemTheRightWayUp) {
  const host::Shot shot = stored({});
  const ordered_json images = web::detail_json(shot, "today", std::nullopt)["images"];
  const auto& frame = shot.digitizations.back().frame;
  for (std::size_t i = 0; i < frame.images.size(); ++i) {
    const double row = images[i]["centre_px"][1].get<double>();
    CHECK_TRUE(row >= 0.0);
    DOUBLES_EQUAL(images[0]["centre_px"][1].get<double>() + frame.images[0].centre_y_px,
                  row + frame.images[i].centre_y_px, 1e-9);
  }
}

TEST(DetailJson, OfAShotWhoseFlashesAreNotKnownUsesNoImage) {
  host::Shot shot = stored({});
  shot.summary.reset();
  const ordered_json detail = web::detail_json(shot, "today", kPhotograph);
  CHECK_TRUE(detail["images"].size() > 5);
  for (const auto& image : detail["images"]) CHECK_FALSE(image["used"].get<bool>());
}

TEST(DetailJson, GivesAngleAndSizeAsATiltedCameraShowsThem) {
  host::Shot shot = stored({});
  host::RigFile rig = *shot.rig;
  // column = y / 2, row = x / 2: as the corrections' test has it.
  rig.camera.map = host::CameraMap{{}, 1.0, {}, {0.0, 2.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 1.0}};
  shot.rig = std::make_shared<const host::RigFile>(rig);
  auto& image = shot.digitizations.back().frame.images[0];
  image.centre_xx_px2 = 0.04;
  image.centre_xy_px2 = 0.01;
  image.centre_yy_px2 = 0.16;
  const ordered_json seen = web::detail_json(shot, "today", kPhotograph)["images"][0];
  DOUBLES_EQUAL(0.5 * image.centre_y_px, seen["centre_px"][0].get<double>(), 1e-9);
  DOUBLES_EQUAL(0.5 * image.centre_x_px, seen["centre_px"][1].get<double>(), 1e-9);
  DOUBLES_EQUAL(0.5 * image.diameter_px, seen["diameter_px"].get<double>(), 1e-9);
  // (cos a, sin a) in the plane is (sin a, cos a) in columns and rows: -pi/2 + a... counter-clockwise, modulo pi.
  const double expected = std::atan2(-std::cos(image.equator_rad), std::sin(image.equator_rad));
  DOUBLES_EQUAL(0.0, std::sin(seen["equator_rad"].get<double>() - expected), 1e-9);
  // Columns are half of y: a quarter of its variance.
  const double expected_px2[] = {0.04, 0.0025, 0.0025, 0.01};
  for (std::size_t i = 0; i < 4; ++i)
    DOUBLES_EQUAL(expected_px2[i], seen["centre_cov_px2"][i].get<double>(), 1e-12);
}

TEST(DetailJson, HasTheFieldsThatTheInterfacesDescriptionLists) {
  const ordered_json detail = web::detail_json(stored({}), "today", kPhotograph);
  auto fields = web_test::documented_fields("ROW:");
  CHECK_TRUE(fields == web_test::fields_of(web::shot_json({}, std::nullopt)));
  fields.merge(web_test::documented_fields("DETAIL is a ROW and:"));
  CHECK_TRUE(fields == web_test::fields_of(detail));
  CHECK_TRUE(web_test::documented_fields("An image, in the photograph's coordinates") ==
             web_test::fields_of(detail["images"][0]));
}

TEST(DetailJson, AdvisesWhatTheConsoleDoes) {
  host::Shot shot = stored({});
  shot.digitizations.clear();
  host::judge_again(shot);
  std::string printed;
  for (const std::string& line : host::render_shot(shot, 40)) {
    const std::string_view begin = "What to do: ";
    if (line.starts_with(begin)) printed = line.substr(begin.size());
    else if (!printed.empty()) printed += line.substr(1);
  }
  CHECK_EQUAL(web::detail_json(shot, "today", std::nullopt)["advice"].get<std::string>(), printed);
}
