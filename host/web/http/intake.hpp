// The bytes of a connection, taken apart into HTTP/1 requests within limits. No I/O; one thread's; any bytes
// are allowed.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

#include "host/web/http/access.hpp"

namespace strobe::web {

inline constexpr std::size_t kMaxHead_bytes = 16 * 1024;

class Intake {
 public:
  enum class State {
    head,      ///< more bytes are needed
    body,      ///< the head is there; step() goes on
    complete,  ///< the request is there
    failed,    ///< it is none that is understood; nothing more is
  };

  Intake();
  ~Intake();
  Intake(const Intake&) = delete;
  Intake& operator=(const Intake&) = delete;

  /// Adds what has come. Bytes of later requests are kept for these.
  void add(std::string_view bytes) { pending_ += bytes; }
  /// Goes on as far as the bytes reach; halts once where a head has just become complete.
  State step();
  State state() const { return state_; }
  /// Whether a request has begun.
  bool begun() const;
  /// Of State::failed: 400, 411 (a body in chunks), 413 (body), 431 (head) or 505.
  int failure_status() const { return failure_status_; }

  /// From State::body on; the views live until next().
  RequestHead head() const;
  bool keep_alive() const;
  bool expects_continue() const;
  /// Of State::complete.
  std::string take_body();
  /// Makes ready for the next request.
  void next();

 private:
  struct Parser;

  void fail(int status);

  std::unique_ptr<Parser> parser_;
  std::string pending_;
  State state_ = State::head;
  int failure_status_ = 400;
};

}  // namespace strobe::web
