// Makes the system's file calls fail: a library that stands before libc. Linked into a test, or preloaded into a
// whole program with STROBE_DISK_FAULT set (see parse()). Only descriptors of files below one folder are touched,
// and only those whose path has a given part. One fault at a time; counts are of this process.
#pragma once

#include <optional>
#include <string>

namespace strobe::testing {

struct DiskFault {
  std::string folder;  ///< absolute; files elsewhere are left alone
  std::string file;    ///< a part of the path
  std::string call;    ///< write, fsync, close, rename, open (of files to be written), truncate, link, flock;
                       ///< memory: allocations, wherever they are made
  int nth = 1;         ///< of the matching calls, from 1
  int times = 1;       ///< so many in a row fail
  int error = 0;       ///< errno
  int short_bytes = 0;        ///< write: the first call writes so many bytes and says so, the next ones fail
  bool truncate_too = false;  ///< while it lasts, nothing can be cut off either
};

/// "folder=/x,file=host-,call=write,nth=5,times=1,error=28,short=10"; nullopt if it is not of this form.
std::optional<DiskFault> parse_disk_fault(const std::string& text);
std::string to_text(const DiskFault& fault);

/// From now on. Counting starts anew.
void set_disk_fault(const DiskFault& fault);
/// No more of them; what was injected can still be asked for.
void clear_disk_fault();
/// How many calls were made to fail.
int disk_faults_injected();

}  // namespace strobe::testing
