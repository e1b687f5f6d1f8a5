#include "host/web/archive/report_maker.hpp"

#include <exception>
#include <functional>
#include <utility>

#include "common/config/files.hpp"
#include "host/report/build_report.hpp"
#include "host/report/content/summarize_shots.hpp"
#include "host/report/html/render_html.hpp"

namespace strobe::web {
namespace {

std::optional<thesis::ThesisInputs> shipped_thesis() {
  const auto share = config::share_folder();
  if (!share) return std::nullopt;
  auto inputs = thesis::load_inputs(*share / "thesis", thesis::Version::corrected, "");
  return inputs ? std::optional(std::move(*inputs)) : std::nullopt;
}

}  // namespace

std::string session_report_html(const host::StoredSession& session, const std::string& version,
                                const std::function<void(std::size_t, std::size_t)>& progress) {
  lab_report::ReportInput input;
  input.version = version;
  input.sessions.push_back(session);
  input.summarize = lab_report::summarize_shots(input.sessions);
  const auto thesis = shipped_thesis();
  input.thesis = thesis ? &*thesis : nullptr;
  input.progress = [&progress](std::size_t done, std::size_t of, const std::string&) { progress(done, of); };
  return lab_report::render_html(lab_report::build_report(input));
}

ReportMaker::State ReportMaker::report(const std::string& id, const std::string& state,
                                       std::shared_ptr<const host::StoredSession> session) {
  const std::lock_guard lock(made_->mutex);
  Made& made = *made_;
  if (made.id == id && made.state == state && (made.busy || made.html || !made.problem.empty()))
    return {made.html, made.done, made.of, made.problem};
  if (made.busy) return {nullptr, made.done, made.of, ""};
  made.id = id;
  made.state = state;
  made.html = nullptr;
  made.problem.clear();
  made.done = made.of = 0;
  made.busy = worker_.add([making = made_, session = std::move(session), version = version_] {
    std::shared_ptr<const std::string> html;
    std::string problem;
    try {
      html = std::make_shared<const std::string>(
          session_report_html(*session, version, [&making](std::size_t done, std::size_t of) {
            const std::lock_guard told(making->mutex);
            making->done = done;
            making->of = of;
          }));
    } catch (const std::exception& error) {  // memory
      problem = error.what();
    }
    const std::lock_guard done(making->mutex);
    making->html = std::move(html);
    making->problem = std::move(problem);
    making->busy = false;
  });
  return {};
}

}  // namespace strobe::web
