// Sessions with photographs, as a host stores them: rendered by strobe-sim on a small sensor, so that they are quick to
// measure, with the flashes' times that the simulator tells. Writes files; failures fail the test.
#pragma once

#include <filesystem>
#include <string>

#include "common/authentication/key.hpp"
#include "tests/support/temporary_folder.hpp"

namespace strobe::others {

class StoredPhotographs {
 public:
  StoredPhotographs();

  /// A session of so many shots of a shipped scene.
  std::filesystem::path add_session(const std::string& name, const std::string& scene, int shots);
  const std::filesystem::path& path() const { return folder_.path(); }
  /// With which the sessions' logs are sealed.
  std::filesystem::path key_file() const { return keys_ / "lab.key"; }

 private:
  testing::TemporaryFolder folder_, keys_;
  authentication::Key key_ = authentication::Key::random();
  std::int64_t boot_ = 0x100;  ///< of the session that was added last
};

}  // namespace strobe::others
