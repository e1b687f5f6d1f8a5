// A network of the test's own, so that LCM sessions beside it neither hear it nor are heard.
#pragma once

#include <string>

#include "tests/support/temporary_folder.hpp"

namespace strobe::testing {

/// Moves this process, and with it all that it will start, into a new network namespace with a loopback
/// interface that carries multicast. Needs root or unprivileged user namespaces; call it before any thread is
/// started. Returns an empty text, or why it could not be done (then nothing that matters has changed).
std::string enter_private_network();

/// Where programs under test run, while it lives: in a private network if one can be had (else that is told on standard
/// error, and they run in this one), with an empty configuration folder for the key that they make. Make it before any
/// thread is started.
class IsolatedEnvironment {
 public:
  IsolatedEnvironment();

 private:
  TemporaryFolder configuration_;
};

/// An LCM URL with a multicast group and port drawn at random, for where there is no namespace and to keep
/// several sessions of one namespace apart.
std::string private_lcm_url();

}  // namespace strobe::testing
