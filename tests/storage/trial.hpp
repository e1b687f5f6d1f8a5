// One fault of the disk, drawn from a seed, while a host stores something; and the verdict: nothing that was told
// as stored is missing, nothing stored before is lost, every loss was told, within a second, and no shot was fired
// after that. Deterministic in the seed. One at a time.
#pragma once

#include <cstdint>
#include <string>

#include "tests/storage/disk_faults.hpp"

namespace strobe::storage {

struct Trial {
  std::uint64_t seed = 0;
  std::string target;        ///< what is stored: "session", "replaced file", "copied file", "key"
  testing::DiskFault fault;  ///< folder is filled in by run_trial()
};

/// The table's row.
enum class Ending {
  not_reached,    ///< the call was not made so often
  harmless,       ///< all is stored, nothing had to be told
  refused,        ///< told at the start; nothing was begun, nothing touched
  told_stored,    ///< told, the series ended, and all was stored after all
  told_unstored,  ///< told, the series ended, and what is missing was named
};
const char* name(Ending ending);

struct Verdict {
  Ending ending = Ending::not_reached;
  std::string violation;  ///< empty: none
  std::string told;       ///< the first line told
};

Trial draw(std::uint64_t seed);
Verdict run_trial(Trial trial);

}  // namespace strobe::storage
