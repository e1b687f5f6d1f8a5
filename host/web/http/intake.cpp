#include "host/web/http/intake.hpp"

#include <boost/asio/buffer.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>
#include <cassert>
#include <optional>

#include "host/web/http/message.hpp"

namespace strobe::web {
namespace {

namespace http = boost::beast::http;

std::string_view view_of(boost::beast::string_view text) { return {text.data(), text.size()}; }

std::optional<std::string_view> field(const http::fields& fields, boost::beast::string_view name) {
  const auto found = fields.find(name);
  if (found == fields.end()) return std::nullopt;
  return view_of(found->value());
}

int status_of(const boost::beast::error_code& error) {
  if (error == http::error::header_limit) return 431;
  if (error == http::error::body_limit) return 413;
  return error == http::error::bad_version ? 505 : 400;
}

}  // namespace

struct Intake::Parser {
  Parser() {
    request.header_limit(static_cast<std::uint32_t>(kMaxHead_bytes));
    request.body_limit(kMaxBody_bytes);
    request.eager(true);
  }
  http::request_parser<http::string_body> request;
};

Intake::Intake() : parser_(std::make_unique<Parser>()) {}
Intake::~Intake() = default;

bool Intake::begun() const { return !pending_.empty() || parser_->request.got_some(); }

void Intake::fail(int status) {
  state_ = State::failed;
  failure_status_ = status;
  pending_.clear();
}

Intake::State Intake::step() {
  if (state_ == State::failed || state_ == State::complete) return state_;
  auto& request = parser_->request;
  const bool had_head = request.is_header_done();
  request.eager(had_head);  // else it halts after the head
  while (!pending_.empty() && !request.is_done()) {
    boost::beast::error_code error;
    const std::size_t used = request.put(boost::asio::buffer(pending_), error);
    pending_.erase(0, used);
    if (error == http::error::need_more) break;
    if (error) {
      fail(status_of(error));
      return state_;
    }
    if (!had_head && request.is_header_done()) break;
    if (used == 0) break;
  }
  // Boost 1.74 asserts on some malformed chunks; no browser and no script needs them.
  if (request.is_header_done() && request.get().find(http::field::transfer_encoding) != request.get().end()) {
    fail(411);
    return state_;
  }
  if (request.is_done()) {
    state_ = had_head ? State::complete : State::body;
  } else if (request.is_header_done()) {
    state_ = State::body;
  }
  return state_;
}

RequestHead Intake::head() const {
  assert(parser_->request.is_header_done());
  const auto& fields = parser_->request.get();
  RequestHead head;
  head.method = view_of(fields.method_string());
  head.target = view_of(fields.target());
  const auto hosts = fields.equal_range(http::field::host);
  for (auto host = hosts.first; host != hosts.second; ++host) head.hosts.push_back(view_of(host->value()));
  head.origin = field(fields, "Origin");
  head.authorization = field(fields, "Authorization");
  head.cookie = field(fields, "Cookie");
  head.content_type = field(fields, "Content-Type");
  head.etag = field(fields, "If-None-Match");
  head.last_event_id = field(fields, "Last-Event-ID");
  head.fetch_site = field(fields, "Sec-Fetch-Site");
  head.fetch_mode = field(fields, "Sec-Fetch-Mode");
  head.fetch_dest = field(fields, "Sec-Fetch-Dest");
  return head;
}

bool Intake::keep_alive() const { return parser_->request.get().keep_alive(); }

bool Intake::expects_continue() const {
  const auto expects = field(parser_->request.get(), "Expect");
  return expects && expects->size() == 12 && (*expects)[0] == '1' && parser_->request.get().version() >= 11;
}

std::string Intake::take_body() {
  assert(state_ == State::complete);
  return std::move(parser_->request.get().body());
}

void Intake::next() {
  parser_ = std::make_unique<Parser>();
  state_ = State::head;
}

}  // namespace strobe::web
