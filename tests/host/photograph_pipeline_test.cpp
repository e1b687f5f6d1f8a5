// The camera's folder on a real file system, with a digitizer that reads numbers from text files.
#include "host/photographs/photograph_pipeline.hpp"

#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <fstream>
#include <string>

#include "tests/host/synthetic_shot.hpp"
#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

namespace {

namespace fs = std::filesystem;
using namespace strobe;
using namespace std::chrono_literals;
using host::CameraFolder;
using testing::write_text;

HostTime steady_now() { return from_ns<HostTime>(testing::monotonic_now_ns()); }

/// A photograph is the text "ball X", a dark one "ball X dark"; anything else may be half-written.
tl::expected<host::PhotographReading, host::UnreadPhotograph> measure(const fs::path& file,
                                                                      const std::vector<double>& times) {
  const std::string text = testing::read_text(file);
  if (text == "throw") throw std::runtime_error("thrown");
  if (text.rfind("ball ", 0) != 0)
    return tl::unexpected(host::UnreadPhotograph{file.filename().string() + ": cut short", true});
  host::PhotographReading reading;
  reading.frame.images.resize(1);
  reading.frame.images[0].centre_px = {std::stod(text.substr(5)), static_cast<double>(times.size())};
  reading.frame.images[0].diameter_px = 260.0;
  reading.frame.images[0].source = "auto";
  reading.remarks = {"dim"};
  if (text.ends_with("dark")) {
    reading.advise = [] {
      return std::vector{light::Advice{.what = "exposure",
                                       .value = 3.0,
                                       .verdict = light::Verdict::wrong,
                                       .words = "the felt is dark",
                                       .remedy = "open the aperture"}};
    };
  }
  return reading;
}

std::string all(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

}  // namespace

TEST_GROUP(FolderOfTheCamera) {
  testing::TemporaryFolder folder;
  HostTime now{100s};
  std::unique_ptr<CameraFolder> camera;

  void open() { camera = std::move(*CameraFolder::open(folder.path(), now)); }
  std::string arrived() {
    std::string names;
    for (const auto& arrival : camera->look(now))
      names += arrival.path.filename().string() + (arrival.renamed ? ">" : ".");
    return names;
  }
};

TEST(FolderOfTheCamera, OldFilesAreLeftAlone) {
  write_text(folder / "old.tif", "x");
  open();
  CHECK_EQUAL("", arrived());
  write_text(folder / "new.tif", "x");
  CHECK_EQUAL("new.tif.", arrived());
  CHECK_EQUAL("", arrived());
}

TEST(FolderOfTheCamera, ATemporaryNameIsNoPhotographUntilItIsRenamed) {
  open();
  for (const char* name : {"a.tif.tmp", ".a.tif", "a.tif.part", "a.tif~"}) write_text(folder / name, "x");
  CHECK_EQUAL("", arrived());
  fs::rename(folder / "a.tif.tmp", folder / "a.tif");
  CHECK_EQUAL("a.tif>", arrived());
  CHECK_TRUE(camera->take_notifications().empty());
}

TEST(FolderOfTheCamera, AFileIsThereOnceItsWriterHasClosedIt) {
  open();
  std::ofstream file(folder / "a.tif");
  file << "half" << std::flush;
  CHECK_EQUAL("", arrived());
  file << "whole" << std::flush;
  file.close();
  CHECK_EQUAL("a.tif.", arrived());
}

TEST(FolderOfTheCamera, OtherFilesAreSaidOncePerKind) {
  open();
  for (const char* name : {"a.mov", "b.mov", "notes.txt"}) write_text(folder / name, "x");
  CHECK_EQUAL("", arrived());
  LONGS_EQUAL(2, camera->take_notifications().size());
}

TEST(FolderOfTheCamera, ARawFileIsAPhotograph) {
  open();
  write_text(folder / "a.CR2", "x");
  CHECK_EQUAL("a.CR2.", arrived());
}

TEST(FolderOfTheCamera, ANameThatIsUsedAgainIsANewPhotograph) {
  write_text(folder / "latest.tif", "one");
  open();
  write_text(folder / "latest.tif", "three");
  CHECK_EQUAL("latest.tif.", arrived());
}

TEST(FolderOfTheCamera, WhatTheKernelDoesNotTellIsSeenByLooking) {
  open();
  // A hard link is neither closed nor renamed here: no event tells of it, as of files on a network's server.
  testing::TemporaryFolder elsewhere;
  write_text(elsewhere / "a.tif", "x");
  std::error_code error;
  fs::create_hard_link(elsewhere / "a.tif", folder / "a.tif", error);
  CHECK_FALSE(error);
  now += 1s;
  CHECK_EQUAL("", arrived());  // may be growing
  now += 1s;
  CHECK_EQUAL("a.tif.", arrived());
}

TEST(FolderOfTheCamera, ThatGoesAwayAndComesBackIsSaid) {
  open();
  fs::remove_all(folder.path());
  CHECK_EQUAL("", arrived());
  STRCMP_CONTAINS("is gone", all(camera->take_notifications()).c_str());
  fs::create_directory(folder.path());
  now += 1s;
  arrived();
  STRCMP_CONTAINS("is back", all(camera->take_notifications()).c_str());
  write_text(folder / "a.tif", "x");
  CHECK_EQUAL("a.tif.", arrived());
}

TEST(FolderOfTheCamera, ThatIsNotThereIsAnError) {
  STRCMP_CONTAINS("no such folder", CameraFolder::open(folder / "none", now).error().message.c_str());
}

TEST_GROUP(PipelineOfPhotographs) {
  testing::TemporaryFolder folder;
  testing::TemporaryFolder session;
  host::DeviceClock clock;
  std::unique_ptr<host::PhotographPipeline> pipeline;
  std::string said;

  void setup() override { open(0.3); }
  void open(double retry_timeout_s) {
    host::PhotographSettings settings;
    settings.timeout_s = 1000.0;  // no machine is that slow
    settings.host_id = 5;
    settings.keep_folder = session.path();
    settings.retry_timeout_s = retry_timeout_s;
    auto camera = std::move(*CameraFolder::open(folder.path(), steady_now()));
    pipeline = std::make_unique<host::PhotographPipeline>(clock, std::move(camera), measure, settings);
    const HostTime now = steady_now();
    const Duration elapsed = now.time_since_epoch();
    clock.on_heartbeat(77, {MonoTime{elapsed}, WallTime{elapsed}, elapsed}, now);
  }
  /// A shot whose shutter has just closed.
  void shot(int id) {
    auto made = host_test::make_shot({});
    made.shot.shot_id = id;
    made.shot.shutter_close_ns = to_ns(steady_now());
    made.shot.shutter_open_ns = made.shot.shutter_close_ns - 500'000'000;
    pipeline->on_shot(made.shot);
  }
  void put(const std::string& name, const std::string& text) {
    write_text(folder / (name + ".tmp"), text);
    fs::rename(folder / (name + ".tmp"), folder / name);
  }
  /// Until that many frames have been measured, or that much has been said.
  std::vector<strobe_msgs::frame_t> step_until(std::size_t frames, const std::string& words) {
    std::vector<strobe_msgs::frame_t> result;
    testing::wait_until(
        [&] {
          pipeline->step(steady_now());
          for (auto& frame : pipeline->take_frames()) result.push_back(std::move(frame));
          said += all(pipeline->take_notifications());
          return result.size() >= frames && said.find(words) != std::string::npos;
        },
        20s);
    LONGS_EQUAL(frames, result.size());
    STRCMP_CONTAINS(words.c_str(), said.c_str());
    return result;
  }
};

TEST(PipelineOfPhotographs, MakesTheFrameOfAShotAndKeepsThePhotograph) {
  shot(3);
  put("IMG_1.tif", "ball 700");
  const auto frame = step_until(1, "photograph of shot 3: dim").front();
  LONGS_EQUAL(77, frame.boot_id);
  LONGS_EQUAL(3, frame.shot_id);
  LONGS_EQUAL(5, frame.host_id);
  CHECK_EQUAL("auto", frame.source);
  DOUBLES_EQUAL(700.0, frame.images.at(0).centre_x_px, 0.0);
  DOUBLES_EQUAL(166.0, frame.images.at(0).centre_y_px, 0.0);  // all flashes' times were given
  CHECK_EQUAL("photographs/shot-0003-IMG_1.tif", frame.photograph);
  CHECK_EQUAL("ball 700", testing::read_text(session / frame.photograph));
}

TEST(PipelineOfPhotographs, WhatIsNotWellWithTheLightIsSaidOnce) {
  shot(1);
  put("a.tif", "ball 1 dark");
  step_until(1, "the felt is dark");
  STRCMP_CONTAINS("photograph of shot 1: ", said.c_str());
  said.clear();
  shot(2);
  put("b.tif", "ball 2 dark");
  step_until(1, "photograph of shot 2: dim");
  shot(3);
  put("c.tif", "ball 3");
  step_until(1, "photograph of shot 3: dim");  // the light of the one before it has been judged
  CHECK_TRUE(said.find("the felt is dark") == std::string::npos);
}

TEST(PipelineOfPhotographs, OneThatWasRenamedIsKeptBeforeItIsMeasured) {
  write_text(folder / "a.tif", "x");
  std::atomic<bool> kept{false};
  host::PhotographReader reader(
      [&](const fs::path&, const std::vector<double>&) {
        kept = fs::exists(session / "photographs/a.tif");
        return host::PhotographReading{};
      },
      0.3);
  host::PhotographJob job;
  job.file = folder / "a.tif";
  job.keep_as = session / "photographs/a.tif";
  job.may_link = true;
  reader.add(job);
  CHECK_TRUE(testing::wait_until([&] { return !reader.take_results().empty(); }, 20s));
  CHECK_TRUE(kept);
}

TEST(PipelineOfPhotographs, KeepsTwoOfOneNameBoth) {
  for (const char* text : {"ball 1", "ball 2"}) {
    shot(text[5] - '0');
    put("latest.tif", text);
    const auto frame = step_until(1, "").front();
    CHECK_EQUAL(text, testing::read_text(session / frame.photograph));
  }
  CHECK_EQUAL("ball 1", testing::read_text(session / "photographs/shot-0001-latest.tif"));
}

TEST(PipelineOfPhotographs, AnUnreadableOneIsSaidAndAnotherMayFollow) {
  shot(1);
  put("a.tif", "garbage");
  step_until(0, "photograph of shot 1: a.tif: cut short");
  CHECK_FALSE(fs::exists(session / "photographs/shot-0001-a.tif"));
  put("b.tif", "ball 2");
  step_until(1, "");
}

TEST(PipelineOfPhotographs, AHalfWrittenOneIsReadOnceItIsWhole) {
  open(20.0);  // longer than a busy machine takes for the second half
  shot(1);
  write_text(folder / "a.tif", "bal");  // closed, and opened again
  pipeline->step(steady_now());
  testing::sleep_for(60ms);
  write_text(folder / "a.tif", "ball 4");
  step_until(1, "dim");
}

TEST(PipelineOfPhotographs, WhatTheDigitizerThrowsIsSaid) {
  shot(1);
  put("a.tif", "throw");
  step_until(0, "a.tif: thrown");
}

TEST(PipelineOfPhotographs, TwoFormatsOfAnExposureAreOnePhotograph) {
  shot(1);
  put("a.tif", "ball 1");
  put("a.jpg", "ball 1");
  step_until(1, "");
  pipeline->end(steady_now());
  CHECK_EQUAL("", all(pipeline->take_notifications()));
}

TEST(PipelineOfPhotographs, AnExtraOneIsSaidAtTheEndAtLatest) {
  put("a.tif", "ball 1");
  pipeline->step(steady_now());
  pipeline->end(steady_now());
  CHECK_EQUAL("photograph a.tif: no shot waits for a photograph: not used\n",
              all(pipeline->take_notifications()));
}

TEST(PipelineOfPhotographs, OneThatSomebodyElseMeasuredIsOnlyKept) {
  shot(1);
  strobe_msgs::frame_t frame{};
  frame.boot_id = 77;
  frame.shot_id = 1;
  pipeline->on_frame(frame);
  put("a.tif", "ball 1");
  CHECK_TRUE(testing::wait_until(
      [&] {
        pipeline->step(steady_now());
        return fs::exists(session / "photographs/shot-0001-a.tif") && pipeline->pending() == 0;
      },
      20s));
  CHECK_TRUE(pipeline->take_frames().empty());
}
