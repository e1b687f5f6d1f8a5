#include "firmware/linux/lifeline.hpp"

#include <cerrno>

namespace strobe::firmware {

Lifeline::Lifeline() {
  pthread_mutexattr_t attributes;
  pthread_mutexattr_init(&attributes);
  pthread_mutexattr_setpshared(&attributes, PTHREAD_PROCESS_SHARED);
  pthread_mutexattr_setrobust(&attributes, PTHREAD_MUTEX_ROBUST);
  pthread_mutex_init(&mutex_, &attributes);
  pthread_mutexattr_destroy(&attributes);
}

bool Lifeline::wait_for_death() noexcept {
  const bool died = pthread_mutex_lock(&mutex_) == EOWNERDEAD;
  if (died) pthread_mutex_consistent(&mutex_);
  pthread_mutex_unlock(&mutex_);
  return died;
}

}  // namespace strobe::firmware
