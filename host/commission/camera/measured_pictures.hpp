// Photographs measured on a thread of their own while the host loop goes on. Not thread-safe itself; waits in its
// destructor for the one under way.
#pragma once

#include <filesystem>
#include <future>
#include <string>
#include <vector>

#include "host/config/rig_file.hpp"
#include "host/photographs/measure_photograph.hpp"

namespace strobe::commission {

class MeasuredPictures {
 public:
  struct Picture {
    std::optional<host::MeasuredPhotograph> measured;
    std::string problem;  ///< why there is none
  };

  /// In the order in which they are added, one at a time.
  void add(const std::filesystem::path& file, const host::RigFile& rig, std::vector<double> flash_times_s);
  bool ready() const;
  /// Once ready. Again: nothing.
  std::vector<Picture> take();
  std::size_t size() const { return pictures_.size(); }

 private:
  std::vector<std::shared_future<void>> order_;
  std::vector<std::future<Picture>> pictures_;
};

}  // namespace strobe::commission
