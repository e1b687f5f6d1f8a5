#include "firmware/publisher/rejections.hpp"

namespace strobe::firmware {

using authentication::kRejectionCount;
using authentication::Rejection;

void Rejections::note(Rejection why) {
  counts_[static_cast<std::size_t>(why)].fetch_add(1, std::memory_order_relaxed);
  held_back_ = true;
  turn();
}

void Rejections::turn() {
  if (!held_back_) return;
  const MonoTime now = clock_.now();
  if (now < quiet_until_) return;
  quiet_until_ = now + kQuiet;
  held_back_ = false;
  say_("commands ignored: " + words());
  said_ = counts();
}

RejectedCommands Rejections::counts() const noexcept {
  RejectedCommands counts;
  for (std::size_t i = 0; i < kRejectionCount; ++i) counts.counts[i] = count(static_cast<Rejection>(i));
  return counts;
}

std::string Rejections::words() const {
  std::string words;
  for (std::size_t i = 0; i < kRejectionCount; ++i) {
    const auto why = static_cast<Rejection>(i);
    const std::int64_t fresh = count(why) - said_[why];
    if (fresh == 0) continue;
    words += (words.empty() ? "" : ", ") + std::to_string(fresh) + " " + authentication::name(why);
  }
  if (count(Rejection::forged) > said_[Rejection::forged]) words += " (has that host this lab's key?)";
  return words;
}

}  // namespace strobe::firmware
