// What a camera is set to so that its photographs can be measured, by the names of GenICam's Standard
// Features Naming Convention (SFNC 2.7) and older ones; what became of each setting; and what changes by
// itself later. Talks to the camera; one thread's.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "host/drivers/genicam/camera.hpp"
#include "host/tether/driver_messages.hpp"

namespace strobe::genicam {

class Settings {
 public:
  /// Sets all, in the order in which features depend on each other; acquisition must stand still.
  Settings(Camera& camera, const tether::OpenRequest& request);

  const std::vector<tether::Setting>& all() const { return settings_; }
  const std::vector<tether::Problem>& problems() const { return problems_; }
  /// For a person.
  const std::string& exposure() const { return exposure_; }

  /// Reads one of them again, the next at each call. Returns true if it has changed by itself: its setting
  /// and a problem say so.
  bool look_again(const Camera& camera);
  std::size_t count() const { return settings_.size(); }

 private:
  void set(const std::string& name, const std::string& value, bool prevents, const std::string& spoils);
  /// The first that the camera has; "" if none.
  std::string present(const std::vector<std::string>& names) const;
  void set_entry(const std::string& name, const std::vector<std::string>& entries, bool prevents,
                 const std::string& spoils);
  void set_trigger();
  void set_line(const std::string& line);
  void set_exposure();
  void set_timed();
  void set_pixel_format();
  void set_lowest_gain();
  void switch_off_corrections();
  void set_asked_besides();
  void read_others();
  void judge_network();

  Camera* camera_;  ///< while it is being set
  tether::OpenRequest request_;
  std::vector<tether::Setting> settings_;
  std::vector<tether::Problem> problems_;
  std::string exposure_;
  std::size_t next_ = 0;
};

}  // namespace strobe::genicam
