#include "host/web/http/connection.hpp"

#include <boost/asio/post.hpp>
#include <boost/asio/write.hpp>
#include <cassert>
#include <charconv>
#include <utility>

#include "host/web/http/message.hpp"

namespace strobe::web {
namespace {

namespace net = boost::asio;
using boost::system::error_code;

constexpr std::size_t kMaxEvents_bytes = 64 * 1024;  // in one piece
constexpr std::size_t kMaxDiscarded_bytes = 1024 * 1024;
constexpr std::chrono::milliseconds kLinger{1000};

/// Where the viewer was: Last-Event-ID, else ?after=. Nothing: he has only just come.
std::int64_t seen_by(const RequestHead& head, const Request& request) {
  const auto after = request.query.find("after");
  const std::string_view text = head.last_event_id             ? *head.last_event_id
                                : after == request.query.end() ? ""
                                                               : std::string_view(after->second);
  std::int64_t id = -1;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), id);
  return read.ec == std::errc() && read.ptr == text.data() + text.size() ? id : -1;
}

}  // namespace

Connection::Connection(net::ip::tcp::socket socket, Services& services)
    : socket_(std::move(socket)), services_(services), deadline_(services.io) {
  error_code error;
  const auto remote = socket_.remote_endpoint(error);
  if (!error) address_ = remote.address().to_string();
  socket_.set_option(net::ip::tcp::no_delay(true), error);
  socket_.set_option(net::socket_base::send_buffer_size(128 * 1024), error);
}

void Connection::start() {
  set_deadline(services_.patience.first_request);
  read();
}

void Connection::close() {
  if (std::exchange(closed_, true)) return;
  assert(!streaming_ || services_.viewers > 0);
  if (streaming_) --services_.viewers;
  error_code error;
  deadline_.cancel();
  socket_.close(error);
  services_.on_closed(*this);
}

void Connection::set_deadline(std::chrono::milliseconds patience) {
  deadline_.expires_after(patience);
  deadline_.async_wait([self = shared_from_this()](error_code error) {
    // It may have been moved on while this was on its way.
    if (!error && self->deadline_.expiry() <= std::chrono::steady_clock::now()) self->close();
  });
}

void Connection::clear_deadline() { deadline_.expires_at(std::chrono::steady_clock::time_point::max()); }

void Connection::read() {
  socket_.async_read_some(net::buffer(received_),
                          [self = shared_from_this()](error_code error, std::size_t size) {
                            if (error) return self->close();
                            if (!self->intake_.begun() && self->answered_)
                              self->set_deadline(self->services_.patience.request);
                            self->intake_.add({self->received_.data(), size});
                            self->go_on();
                          });
}

void Connection::go_on() {
  const bool had_head = intake_.state() == Intake::State::body;
  switch (intake_.step()) {
    case Intake::State::head:
      return read();
    case Intake::State::body:
      return had_head ? read() : on_head();
    case Intake::State::complete:
      return on_request();
    case Intake::State::failed:
      return respond(error_response(intake_.failure_status(), "this is no request that is understood"),
                     false);
  }
}

void Connection::on_head() {
  const RequestHead head = intake_.head();
  known_ = head.etag.value_or("");
  auto verdict = services_.gate.on_head(head);
  if (const auto* refused = std::get_if<Response>(&verdict)) return respond(*refused, false);
  trusted_ = true;
  admitted_ = std::move(std::get<Admitted>(verdict));
  admitted_->request.from = address_;
  if (admitted_->events) seen_ = seen_by(head, admitted_->request);
  if (!intake_.expects_continue()) return go_on();
  head_ = "HTTP/1.1 100 Continue\r\n\r\n";
  net::async_write(socket_, net::buffer(head_), [self = shared_from_this()](error_code error, std::size_t) {
    return error ? self->close() : self->go_on();
  });
}

void Connection::on_request() {
  clear_deadline();
  admitted_->request.body = intake_.take_body();
  if (admitted_->events) return stream();
  const bool keep_alive = intake_.keep_alive();
  if (admitted_->file) return respond(*admitted_->file, keep_alive);
  if (admitted_->found.work == Work::slow) return work(services_.worker);
  if (admitted_->found.work == Work::waits) return work(services_.waiter);
  if (admitted_->found.work == Work::lasts) return work(services_.maker);
  respond(Router::answer(admitted_->found, admitted_->request), keep_alive);
}

/// On the worker's thread, which hands the answer back.
void Connection::work(Worker& worker) {
  const bool taken = worker.add([self = shared_from_this()]() mutable {
    Response response = Router::answer(self->admitted_->found, self->admitted_->request);
    net::io_context& io = self->services_.io;
    net::post(io, [self = std::move(self), response = std::move(response)] {
      if (!self->closed_) self->respond(response, self->intake_.keep_alive());
    });
  });
  if (!taken) respond(error_response(503, "too many requests wait: try again"), intake_.keep_alive());
}

void Connection::respond(const Response& response, bool keep_alive) {
  const bool head_only = admitted_ && admitted_->request.method == "HEAD";
  Answer answer = answer_of(response, head_only, keep_alive, known_);
  write(std::move(answer.head), std::move(answer.body), keep_alive);
}

void Connection::write(std::string head, std::shared_ptr<const std::string> body, bool keep_alive) {
  head_ = std::move(head);
  body_ = std::move(body);
  set_deadline(services_.patience.write);
  const std::array<net::const_buffer, 2> parts{net::buffer(head_),
                                               body_ ? net::buffer(*body_) : net::const_buffer()};
  net::async_write(socket_, parts, [self = shared_from_this(), keep_alive](error_code error, std::size_t) {
    return error ? self->close() : self->written(keep_alive);
  });
}

void Connection::written(bool keep_alive) {
  body_.reset();
  admitted_.reset();
  if (!keep_alive) return linger();
  answered_ = true;
  intake_.next();
  set_deadline(intake_.begun() ? services_.patience.request : services_.patience.idle);
  go_on();
}

/// Closed at once, the system would take the answer back from a viewer who is still sending.
void Connection::linger() {
  error_code error;
  socket_.shutdown(net::ip::tcp::socket::shutdown_send, error);
  if (discarded_ == 0) set_deadline(kLinger);
  socket_.async_read_some(
      net::buffer(received_), [self = shared_from_this()](error_code failed, std::size_t size) {
        self->discarded_ += size;
        return failed || self->discarded_ > kMaxDiscarded_bytes ? self->close() : self->linger();
      });
}

void Connection::stream() {
  if (services_.viewers >= services_.max_viewers)
    return respond(error_response(503, "too many viewers: close one, or try again"), false);
  streaming_ = true;
  ++services_.viewers;
  write_events(events_head());
  // Nothing more is asked on this connection; its end is.
  socket_.async_read_some(net::buffer(received_),
                          [self = shared_from_this()](error_code, std::size_t) { self->close(); });
}

void Connection::write_events(std::string text) {
  assert(streaming_ && !writing_);
  writing_ = true;
  head_ = std::move(text);
  set_deadline(services_.patience.write);
  net::async_write(socket_, net::buffer(head_), [self = shared_from_this()](error_code error, std::size_t) {
    self->writing_ = false;
    if (error) return self->close();
    self->clear_deadline();
    self->send_events();
  });
}

void Connection::send_events() {
  if (writing_ || closed_) return;
  EventHub::Taken taken = services_.hub.take_after(seen_, kMaxEvents_bytes);
  seen_ = taken.last_id;
  if (!taken.text.empty()) write_events(std::move(taken.text));
}

void Connection::ping() {
  if (!writing_ && !closed_) write_events(":\n\n");
}

}  // namespace strobe::web
