#include "firmware/linux/shared_status.hpp"

#include <cerrno>

namespace strobe::firmware {

Lifeline::Lifeline() {
  pthread_mutexattr_t attributes;
  pthread_mutexattr_init(&attributes);
  pthread_mutexattr_setpshared(&attributes, PTHREAD_PROCESS_SHARED);
  pthread_mutexattr_setrobust(&attributes, PTHREAD_MUTEX_ROBUST);
  pthread_mutex_init(&waited_for_, &attributes);
  pthread_mutex_init(&looked_at_, &attributes);
  pthread_mutexattr_destroy(&attributes);
}

/// The first to have the dead holder's mutex makes it good for whoever comes next.
void Lifeline::take_over(pthread_mutex_t& mutex, int lock_result) noexcept {
  if (lock_result == EOWNERDEAD) {
    died_ = true;
    pthread_mutex_consistent(&mutex);
  }
  pthread_mutex_unlock(&mutex);
}

bool Lifeline::wait_for_death() noexcept {
  take_over(waited_for_, pthread_mutex_lock(&waited_for_));
  return died_;
}

bool Lifeline::holder_died() noexcept {
  if (const int result = pthread_mutex_trylock(&looked_at_); result != EBUSY) take_over(looked_at_, result);
  return died_;
}

}  // namespace strobe::firmware
