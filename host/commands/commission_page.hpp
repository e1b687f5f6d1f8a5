// The page beside the console of `strobe commission`: shows the run, takes confirmations of what moves nothing, stops.
// Single-threaded.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "host/commands/web_page.hpp"
#include "host/commission/commissioning.hpp"
#include "host/web/commission/commission_routes.hpp"

namespace strobe::host {

class CommissionPage final : public HostListener {
 public:
  /// Does nothing if the page is not asked for. Fails as WebPage::open().
  static Result<std::unique_ptr<CommissionPage>> open(const WebOptions& options, const WebSetup& setup,
                                                      const RigFile& rig);

  /// The loop and the commissioning must outlive the page; the page's address is told.
  void attach(HostLoop& loop, Clock& clock);
  /// After each turn: shows what is new, does what viewers ask for.
  void step(HostLoop& loop, commission::Commissioning& commissioning, const web::RunView& frame);

 private:
  CommissionPage() = default;
  void on_shot_result(const ShotResult& result) override { model_.add(result); }
  void on_notification(const std::string& text) override { model_.add_notification(text); }
  void obey(HostLoop& loop, commission::Commissioning& commissioning);
  void show(const commission::Commissioning& commissioning, web::RunView view);

  std::optional<web::CommissionRun> run_;  // before the page, whose routes refer to it
  std::unique_ptr<WebPage> page_;
  ViewModel model_;
  HostTime shown_;
};

}  // namespace strobe::host
