#include "host/web/live_feed.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "host/session/session_folder.hpp"

namespace strobe::web {
namespace {

constexpr Duration kTellEvery = milliseconds{500};

/// What nobody should see half a second late. Each change of the firmware's state comes with a new status.
bool differ(const LiveStatus& a, const LiveStatus& b) {
  const auto of = [](const LiveStatus& s) {
    return std::tie(s.status, s.silent, s.danger, s.missing, s.activity, s.armed_by, s.shots, s.counted,
                    s.verified, s.photographs_pending, s.can_stop, s.can_disarm);
  };
  return of(a) != of(b);
}

}  // namespace

std::string LiveFeed::now_utc() { return host::utc_for_table(clock_.read().wall); }

void LiveFeed::add(LiveMessage message) {
  if (waiting_.size() >= kMaxWaiting) {
    left_out_ = true;
  } else {
    waiting_.push_back(std::move(message));
  }
}

void LiveFeed::on_shot_result(const host::Shot& result) {
  if (shown_ && !shown_(result.host_id)) return;
  host::Shot told = result;
  told.utc = now_utc();
  add(std::move(told));
  channel_.put(waiting_);
}

void LiveFeed::on_notification(const std::string& text) { add(LiveNotification{now_utc(), text}); }

LiveStatus LiveFeed::status_of(host::HostLoop& loop, const host::ViewModel& model, const Progress& progress) {
  if (model.status && (!heard_ || heard_at_ != loop.session().status_heard())) {
    heard_ = std::make_shared<const strobe_msgs::status_t>(*model.status);
    heard_at_ = loop.session().status_heard();
  }
  LiveStatus status;
  status.status = heard_;
  status.silent = model.silent;
  status.age_s = std::max(0.0, model.status_age_s);
  status.danger = model.danger;
  status.missing = why_nothing_can_be_fired(model);
  status.activity = model.activity;
  if (heard_ && heard_->arm_token != 0) {
    status.armed_by = loop.session().host_name(heard_->arm_host_id);
    if (heard_->arm_host_id == loop.settings().host_id) status.armed_by = loop.settings().host_name;
  }
  status.clock = model.clock;
  status.shots = model.shots;
  status.counted = progress.counted;
  status.wanted = progress.wanted;
  status.events_missing = model.events_missing;
  status.verified = model.verified;
  status.unverified = model.unverified;
  status.photographs_pending = loop.photographs() ? loop.photographs()->pending() : 0;
  status.can_stop = progress.can_stop;
  status.can_disarm = loop.verifies();
  return status;
}

void LiveFeed::step(host::HostLoop& loop, const host::ViewModel& model, const Progress& progress) {
  if (left_out_ && waiting_.empty()) {
    left_out_ = false;
    add(LiveNotification{now_utc(), "the page could not keep up: not all that happened is on it"});
  }
  LiveStatus status = status_of(loop, model, progress);
  const bool due = !told_any_ || loop.now() - told_at_ >= kTellEvery;
  if (due || differ(status, published_)) {
    told_any_ = true;
    told_at_ = loop.now();
    published_ = status;
    if (waiting_.size() < kMaxWaiting / 2) add(std::move(status));
  }
  channel_.put(waiting_);
}

}  // namespace strobe::web
