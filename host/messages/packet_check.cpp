#include "host/messages/packet_check.hpp"

namespace strobe::host {

using authentication::kUnverifiedCount;
using authentication::Unverified;

namespace {

constexpr Duration kQuiet = std::chrono::seconds{10};

std::string words_of(const authentication::UnverifiedCounts& now,
                     const authentication::UnverifiedCounts& before) {
  std::string text;
  for (std::size_t i = 0; i < kUnverifiedCount; ++i) {
    const auto why = static_cast<Unverified>(i);
    if (now[why] == before[why]) continue;
    text += (text.empty() ? "" : ", ") + std::to_string(now[why] - before[why]) + " " +
            authentication::words(why);
  }
  return text;
}

}  // namespace

PacketCheck::PacketCheck(const std::optional<authentication::Key>& key, std::int64_t own_sender)
    : own_sender_(own_sender) {
  if (key) seal_.emplace(*key);
}

std::optional<PacketCheck::Bytes> PacketCheck::open(std::string_view channel, Bytes packet) {
  if (!seal_) return authentication::message_of(packet);
  const auto opened = seal_->open(channel, packet);
  if (!opened) {
    ++counts_[opened.error()];
    return std::nullopt;
  }
  if (opened->number.sender == own_sender_) return std::nullopt;
  if (!windows_.accept(opened->number)) {
    ++counts_[Unverified::replayed];
    return std::nullopt;
  }
  return opened->message;
}

std::optional<std::string> PacketCheck::due_line(HostTime now) {
  // What came twice by the network's fault is nobody's attack: it is counted, and no line's cause.
  const std::int64_t strange = counts_.sum() - counts_[Unverified::replayed];
  const std::int64_t strange_told = told_.sum() - told_[Unverified::replayed];
  if (strange == strange_told || (told_at_ && now - *told_at_ < kQuiet)) return std::nullopt;
  std::string line = "packets ignored that are not the lab's: " + words_of(counts_, told_);
  if (counts_[Unverified::other_key] > told_[Unverified::other_key])
    line += " (has that program this lab's key? see strobe key)";
  told_ = counts_;
  told_at_ = now;
  return line;
}

}  // namespace strobe::host
