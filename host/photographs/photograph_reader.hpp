// Reads and measures photographs on a thread of its own, one after the other, and keeps a copy of each. A
// file that cannot be read may be half-written: it is tried again while it changes and for a while after.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <tl/expected.hpp>
#include <vector>

#include "common/reduction/frame.hpp"
#include "host/light/advice.hpp"
#include "host/photographs/photograph_matcher.hpp"

namespace strobe::host {

using AdviseOnLight = std::function<std::vector<light::Advice>()>;

struct PhotographReading {
  reduction::Frame frame;            ///< images in order of time; times are not used
  std::vector<std::string> remarks;  ///< for a person
  /// Judges the photograph's light, once its frame has been handed on; empty: nobody does.
  AdviseOnLight advise;
};

struct UnreadPhotograph {
  std::string message;
  bool unfinished = false;  ///< may be only half there: worth another try
};

/// Measures the file, given when the flashes of its shot were [s, ascending, any origin]. Called on the
/// reader's thread; an exception counts as a photograph that cannot be read.
using MeasurePhotograph = std::function<tl::expected<PhotographReading, UnreadPhotograph>(
    const std::filesystem::path&, const std::vector<double>& flash_times_s)>;

struct PhotographJob {
  std::filesystem::path file;
  ShotKey shot;
  bool measure = true;            ///< false: it is only kept
  std::filesystem::path keep_as;  ///< empty: not kept
  bool may_link = false;          ///< a hard link does: nobody changes the file in place
  bool left = false;              ///< by an earlier run
  std::vector<double> flash_times_s;
};

struct PhotographResult {
  PhotographJob job;
  tl::expected<PhotographReading, UnreadPhotograph> reading;
  std::string not_kept;  ///< why it could not be kept; empty: it was, or was not to be
};

struct PhotographLight {
  ShotKey shot;
  std::vector<light::Advice> advice;
};

class PhotographReader {
 public:
  /// patience: how long a file that cannot be read may stay unchanged until that is final.
  PhotographReader(MeasurePhotograph measure, double retry_timeout_s);
  /// Waits for the photograph under way.
  ~PhotographReader();
  PhotographReader(const PhotographReader&) = delete;
  PhotographReader& operator=(const PhotographReader&) = delete;

  void add(PhotographJob job);
  std::vector<PhotographResult> take_results();
  /// Of photographs whose results have been taken before.
  std::vector<PhotographLight> take_light();
  /// Readable when there are results; -1 where the system gave none.
  int descriptor() const { return event_; }
  /// Jobs added whose results have not been taken.
  std::size_t pending() const;

 private:
  void run();
  void judge_light(const ShotKey& shot, const AdviseOnLight& advise);
  void wake() const;
  PhotographResult work(PhotographJob job);
  tl::expected<PhotographReading, UnreadPhotograph> read_once(const PhotographJob& job) const;
  tl::expected<PhotographReading, UnreadPhotograph> read_when_whole(const PhotographJob& job);

  MeasurePhotograph measure_;
  double retry_timeout_s_;
  int event_ = -1;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool stopping_ = false;
  std::deque<PhotographJob> jobs_;
  std::vector<PhotographResult> results_;
  std::vector<PhotographLight> light_;
  std::size_t pending_ = 0;
  std::thread thread_;  ///< last: it uses all of the above
};

}  // namespace strobe::host
