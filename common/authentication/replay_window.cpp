#include "common/authentication/replay_window.hpp"

#include <algorithm>

namespace strobe::authentication {

namespace {

std::size_t place(std::int64_t sequence) { return static_cast<std::size_t>(sequence % ReplayWindow::kSize); }

}  // namespace

bool ReplayWindow::accept(std::int64_t sequence) {
  if (sequence < 1 || sequence <= largest_ - kSize) return false;
  if (sequence - largest_ >= kSize) {
    seen_.reset();
    largest_ = sequence;
  }
  while (largest_ < sequence) seen_.reset(place(++largest_));
  if (seen_.test(place(sequence))) return false;
  seen_.set(place(sequence));
  return true;
}

bool ReplayWindows::accept(const PacketNumber& number) {
  auto found = senders_.find(number.sender);
  if (found == senders_.end()) {
    if (senders_.size() >= kMaxSenders) {
      senders_.erase(
          std::ranges::min_element(senders_, {}, [](const auto& sender) { return sender.second->used; }));
    }
    found = senders_.emplace(number.sender, std::make_unique<Sender>()).first;
  }
  found->second->used = ++packets_;
  return found->second->window.accept(number.sequence);
}

}  // namespace strobe::authentication
