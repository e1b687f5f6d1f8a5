// Threads whose work can wait: the host's own comes first.
#pragma once

#include <functional>
#include <thread>

namespace strobe::web {

/// A thread that the scheduler prefers others to (SCHED_BATCH, niceness 10) and that no signal interrupts. name: at most 15
/// characters. What throws ends the thread's work, not the program.
std::thread background_thread(const char* name, std::function<void()> work);

}  // namespace strobe::web
