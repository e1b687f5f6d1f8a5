// Tells of a drift that the shots of a series show, as it starts. Single-threaded.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>

#include "host/loop/host_loop.hpp"
#include "host/series/drift.hpp"
#include "host/view/drift_view.hpp"

namespace strobe::host {

class DriftWatch final : public HostListener {
 public:
  /// Of shots of hosts that `shown` accepts, to all listeners of the loop, which must outlive the object.
  DriftWatch(HostLoop& loop, std::function<bool(std::int64_t host_id)> shown)
      : loop_(loop), shown_(std::move(shown)) {}

  void on_shot_result(const Shot& result) override {
    if (!shown_(result.host_id) || result.dry || result.rejected) return;
    if (charts_.add(result.full_name(), witnesses(result)).empty()) return;
    for (const std::string& line : render_drift(charts_)) loop_.notify(line);
  }

 private:
  HostLoop& loop_;
  std::function<bool(std::int64_t)> shown_;
  WitnessCharts charts_;
};

}  // namespace strobe::host
