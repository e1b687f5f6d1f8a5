#include "host/commands/commission_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

namespace strobe::host {
namespace {

using commission::Answer;
using commission::Commissioning;
using commission::StepState;
using commission::StepView;

constexpr Duration kShowEvery = milliseconds{100};

/// The step that is under way or asks; empty: none.
std::string current_step(const Commissioning& commissioning) {
  for (const StepView& view : commissioning.views())
    if (view.state == StepState::running || view.state == StepState::waiting) return view.info.id;
  for (const StepView& view : commissioning.views())
    if (view.state == StepState::failed && commissioning.prompt()) return view.info.id;
  return "";
}

}  // namespace

Result<std::unique_ptr<CommissionPage>> CommissionPage::open(const WebOptions& options, const WebSetup& setup,
                                                             const RigFile& rig) {
  std::unique_ptr<CommissionPage> made(new CommissionPage());
  auto page = WebPage::open(options, setup, rig, [&made](web::Router& router, web::EventHub& hub) {
    made->run_.emplace(hub);
    web::add_run_routes(router, *made->run_);
  });
  if (!page) return tl::unexpected(page.error());
  made->page_ = std::move(*page);
  return made;
}

void CommissionPage::attach(HostLoop& loop, Clock& clock) {
  if (!page_) return;
  loop.add_listener(*this);
  page_->attach(loop, clock);
  std::fprintf(stderr, "strobe: %s\n", page_->words().c_str());
}

void CommissionPage::step(HostLoop& loop, Commissioning& commissioning, const web::RunView& frame) {
  if (!page_) return;
  obey(loop, commissioning);
  if (loop.now() - shown_ < kShowEvery) return;
  shown_ = loop.now();
  model_.activity = commissioning.waiting();
  static_cast<void>(model_.update(loop.session(), loop.now()));
  page_->step(loop, model_, {0, std::nullopt, !commissioning.finished()});
  show(commissioning, frame);
}

void CommissionPage::show(const Commissioning& commissioning, web::RunView view) {
  view.running = !commissioning.finished();
  view.steps = commissioning.views();
  view.prompt = commissioning.prompt();
  if (view.prompt) view.prompted_step = current_step(commissioning);
  view.waiting = commissioning.waiting();
  run_->show(view);
}

/// What is asked at the console is answered there alone, whatever the routes have let through.
void CommissionPage::obey(HostLoop& loop, Commissioning& commissioning) {
  for (const web::LiveCommand& command : page_->take_commands()) {
    loop.notify("ended from the page by " + command.from);
    // Whoever armed it: another host may fire.
    if (command.kind == web::LiveCommand::Kind::disarm) loop.disarm("the page at " + command.from);
    commissioning.stop("the page at " + command.from);
  }
  for (const web::CommissionRun::Asked& asked : run_->take_asked()) {
    if (asked.kind == web::CommissionRun::Asked::Kind::more_time) {
      commissioning.stretch();
      continue;
    }
    const auto& prompt = commissioning.prompt();
    if (!prompt || web::asks_at_console(*prompt) || current_step(commissioning) != asked.step) continue;
    loop.notify(fmt::format("{} confirmed from the page by {}", asked.step, asked.from));
    commissioning.answer(Answer::yes);
  }
}

}  // namespace strobe::host
