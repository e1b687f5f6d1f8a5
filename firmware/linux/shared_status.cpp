#include "firmware/linux/shared_status.hpp"

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

/// The first to have the dead holder's mutex makes it good for whoever comes next.
void Lifeline::take_over(int lock_result) noexcept {
  if (lock_result == EOWNERDEAD) {
    died_ = true;
    pthread_mutex_consistent(&mutex_);
  }
  pthread_mutex_unlock(&mutex_);
}

bool Lifeline::wait_for_death() noexcept {
  take_over(pthread_mutex_lock(&mutex_));
  return died_;
}

bool Lifeline::holder_died() noexcept {
  if (const int result = pthread_mutex_trylock(&mutex_); result != EBUSY) take_over(result);
  return died_;
}

}  // namespace strobe::firmware
