// The lock-free queue of one producer and one consumer: moodycamel's, annotated for the thread sanitizer,
// which does not see its fences under g++ and would report every hand-over as a race.
#pragma once

#ifdef __SANITIZE_THREAD__
#include <sanitizer/tsan_interface.h>
namespace strobe::firmware {
inline int tsan_fence;
}
#define AE_TSAN_ANNOTATE_RELEASE() __tsan_release(&strobe::firmware::tsan_fence)
#define AE_TSAN_ANNOTATE_ACQUIRE() __tsan_acquire(&strobe::firmware::tsan_fence)
#endif

#include <readerwriterqueue/readerwriterqueue.h>

namespace strobe::firmware {

/// Allocates at construction only, as long as try_enqueue() is used.
template <typename T>
using SpscQueue = moodycamel::ReaderWriterQueue<T>;

}  // namespace strobe::firmware
