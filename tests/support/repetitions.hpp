// How often tests that count over random draws repeat themselves. Constants only.
#pragma once

namespace strobe::testing {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)  // GCC
inline constexpr bool kSanitized = true;
#elif defined(__has_feature)  // Clang
inline constexpr bool kSanitized = __has_feature(address_sanitizer) || __has_feature(thread_sanitizer);
#else
inline constexpr bool kSanitized = false;
#endif

/// A fifth of `full` under sanitizers: they find along the first draws what they can find, and take ten times
/// as long.
constexpr int repetitions(int full) { return kSanitized ? full / 5 : full; }

/// A tolerance that is meant for the full number, as wide as the number of repetitions needs it.
constexpr double widened(double tolerance) { return kSanitized ? tolerance * 2.23606797749979 : tolerance; }

}  // namespace strobe::testing
