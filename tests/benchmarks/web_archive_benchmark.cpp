// What the page asks of a session of a thousand shots: lists, one shot, the series; for the first time and again.
#include <benchmark/benchmark.h>

#include <filesystem>
#include <fstream>
#include <memory>

#include "common/authentication/key_file.hpp"
#include "host/archive/read_session.hpp"
#include "host/archive/shot_outcome.hpp"
#include "host/web/archive_routes.hpp"
#include "tests/host/archive/written_session.hpp"
#include "tests/support/temporary_folder.hpp"

namespace {

using namespace strobe;
namespace fs = std::filesystem;

constexpr int kShots = 1000;

/// Written once for all.
class Session {
 public:
  static const Session& the() {
    static const Session session;
    return session;
  }
  std::unique_ptr<web::Archive> open() const {
    return std::make_unique<web::Archive>(
        web::SessionStoreSettings{place_ / "sessions", "", (place_ / "lab.key").string(), "1.0"});
  }

 private:
  Session() {
    const auto key = authentication::make_key_file(place_ / "lab.key").value().key;
    const fs::path folder = place_ / "sessions" / "today";
    fs::create_directories(place_ / "sessions");
    {
      host_test::WrittenRun run(folder, key, 5, 0);
      for (int shot = 1; shot <= kShots; ++shot) {
        const auto seed = static_cast<std::uint32_t>(shot);
        run.heartbeat();
        run.arm_and_fire();
        run.started(shot);
        run.ended(shot);
        run.summary(shot, host_test::WrittenRun::kBoot, 0, seed);
        run.frame(shot, host_test::WrittenRun::kBoot, "", seed);
      }
    }
    const auto session = host::read_session(folder, {"", (place_ / "lab.key").string(), {}});
    (void)host::rebuild_results(*session, folder / "results.csv");
  }

  testing::TemporaryFolder place_;
};

web::Response ask(web::Archive& archive, const char* path, std::map<std::string, std::string> query = {}) {
  web::Router router;
  add_archive_routes(router, archive);
  web::Request request{"GET", path, std::move(query), {}, "", ""};
  return router.route(request);
}

void answered(benchmark::State& state, const char* path, const std::map<std::string, std::string>& query,
              bool anew) {
  auto archive = Session::the().open();
  if (!anew) ask(*archive, path, query);
  std::size_t bytes = 0;
  for (auto _ : state) {
    if (anew) archive = Session::the().open();
    const auto response = ask(*archive, path, query);
    if (response.status != 200) state.SkipWithError(response.body->c_str());
    bytes = response.body->size();
  }
  state.counters["bytes"] = static_cast<double>(bytes);
}

void sessions_first(benchmark::State& state) { answered(state, "/api/v1/sessions", {}, true); }
void sessions_again(benchmark::State& state) { answered(state, "/api/v1/sessions", {}, false); }
void shots_first(benchmark::State& state) { answered(state, "/api/v1/sessions/today/shots", {}, true); }
void shots_again(benchmark::State& state) { answered(state, "/api/v1/sessions/today/shots", {}, false); }
void all_shots_again(benchmark::State& state) {
  answered(state, "/api/v1/sessions/today/shots", {{"limit", "2000"}}, false);
}
void shot_first(benchmark::State& state) { answered(state, "/api/v1/sessions/today/shots/500", {}, true); }
void shot_again(benchmark::State& state) { answered(state, "/api/v1/sessions/today/shots/500", {}, false); }
void series_first(benchmark::State& state) { answered(state, "/api/v1/sessions/today/series", {}, true); }
void series_again(benchmark::State& state) { answered(state, "/api/v1/sessions/today/series", {}, false); }

BENCHMARK(sessions_first)->Unit(benchmark::kMillisecond);
BENCHMARK(sessions_again)->Unit(benchmark::kMillisecond);
BENCHMARK(shots_first)->Unit(benchmark::kMillisecond);
BENCHMARK(shots_again)->Unit(benchmark::kMillisecond);
BENCHMARK(all_shots_again)->Unit(benchmark::kMillisecond);
BENCHMARK(shot_first)->Unit(benchmark::kMillisecond);
BENCHMARK(shot_again)->Unit(benchmark::kMillisecond);
BENCHMARK(series_first)->Unit(benchmark::kMillisecond);
BENCHMARK(series_again)->Unit(benchmark::kMillisecond);

}  // namespace
