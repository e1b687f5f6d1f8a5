// A small session as a host stores it: three shots with results, of which one is rejected, and a log of messages sealed
// with a key. Writes files; failures fail the test.
#pragma once

#include <filesystem>
#include <string>

#include "common/authentication/key.hpp"
#include "tests/support/temporary_folder.hpp"

namespace strobe::others {

inline constexpr std::int64_t kBoot = 0x7f00'0000'0000'0001;

struct StoredExample {
  StoredExample();
  std::filesystem::path log() const { return folder / "host-20260131T093000Z.lcmlog"; }

  testing::TemporaryFolder folder;
  authentication::Key key = authentication::Key::random();
  testing::TemporaryFolder keys;
  std::filesystem::path key_file;  ///< beside the session, not in it
};

}  // namespace strobe::others
