// Changes of this machine's network interfaces, addresses and routes, as the kernel tells them
// (rtnetlink(7)). Where it gives no such socket, nothing is ever told. Never blocks; one thread's; allocates
// only for interfaces that vanish.
#pragma once

#include <vector>

namespace strobe::wire {

class LinkChanges {
 public:
  LinkChanges();
  LinkChanges(LinkChanges&& other) noexcept;
  LinkChanges& operator=(LinkChanges&& other) noexcept;
  ~LinkChanges();

  struct Since {
    bool any = false;
    std::vector<int> vanished;  ///< indices of interfaces; one made anew since may have the same
  };
  /// Since the last call.
  Since take();

 private:
  int fd_ = -1;
};

}  // namespace strobe::wire
