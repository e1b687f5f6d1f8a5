// A viewer's end of a connection, byte by byte: what it sends need not be HTTP. For tests; throws std::runtime_error.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace strobe::testing {

class RawClient {
 public:
  /// Connects to 127.0.0.1. receive_buffer_bytes: 0: as the system has it.
  explicit RawClient(std::uint16_t port, int receive_buffer_bytes = 0);
  ~RawClient();
  RawClient(RawClient&& other) noexcept;
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;

  /// False if the server has closed the connection.
  bool send(std::string_view bytes);
  /// What has come, up to and with `end`; less if the server closes before. Fails after 30 s.
  std::string read_until(std::string_view end);
  /// An answer: head and as much body as it says.
  std::string read_answer();
  /// All until the server closes.
  std::string read_all();
  /// Whether something has come that was not read yet.
  bool has_something() const;
  void close();

 private:
  bool receive();

  int fd_ = -1;
  std::string received_;
};

/// "GET PATH HTTP/1.1", Host and the further fields, each with its line's end.
std::string get(std::string_view path, std::string_view fields = "", std::string_view host = "127.0.0.1");
std::string post(std::string_view path, std::string_view body, std::string_view fields = "");

}  // namespace strobe::testing
