#include "sim/ptp/responder.hpp"

#include <array>
#include <limits>
#include <utility>

#include "sim/ptp/dataset.hpp"

namespace strobe::sim::ptp {

namespace {

constexpr std::array kOperations{
    Operation::get_device_info,    Operation::open_session,       Operation::close_session,
    Operation::get_storage_ids,    Operation::get_storage_info,   Operation::get_num_objects,
    Operation::get_object_handles, Operation::get_object_info,    Operation::get_object,
    Operation::delete_object,      Operation::initiate_capture,   Operation::get_property_description,
    Operation::get_property_value, Operation::set_property_value, Operation::get_partial_object};
constexpr std::array kEvents{EventCode::object_added, EventCode::property_changed, EventCode::store_full,
                             EventCode::capture_complete};
constexpr std::array kFormats{ObjectFormat::exif_jpeg, ObjectFormat::png, ObjectFormat::tiff,
                              ObjectFormat::dng};

template <typename Codes>
std::vector<std::uint16_t> numbers(const Codes& codes) {
  std::vector<std::uint16_t> numbers;
  for (const auto code : codes) numbers.push_back(number(code));
  return numbers;
}

Answer only(Response code) { return {code, {}, {}}; }

}  // namespace

Answer Responder::device_info() const {
  DatasetWriter writer;
  writer.u16(100).u32(kNikon).u16(100).text("").u16(0);
  writer.array16(numbers(kOperations)).array16(numbers(kEvents)).array16(properties_.codes());
  writer.array16(numbers(kFormats)).array16(numbers(kFormats));
  writer.text("strobe-sim").text("Simulated PTP camera").text("1.0").text(serial_);
  return {Response::ok, {}, writer.take()};
}

Answer Responder::answer(const OperationRequest& request) {
  if (request.code == Operation::get_device_info) return device_info();
  if (request.code == Operation::open_session)
    return only(std::exchange(session_, true) ? Response::session_already_open : Response::ok);
  return session_ ? in_session(request) : only(Response::session_not_open);
}

Answer Responder::in_session(const OperationRequest& request) {
  const auto property = static_cast<std::uint16_t>(request.parameter(0));
  switch (request.code) {
    case Operation::close_session:
      session_ = false;
      return {};
    case Operation::get_property_description:
      return properties_.description(property);
    case Operation::get_property_value:
      return properties_.value(property);
    case Operation::set_property_value:
      return only(properties_.set(property, request.data));
    case Operation::initiate_capture:
      if (card_.full()) return only(Response::store_full);
      return only(std::exchange(capture_, true) ? Response::device_busy : Response::ok);
    default:
      return of_objects(request);
  }
}

Answer Responder::of_objects(const OperationRequest& request) {
  const std::uint32_t first = request.parameter(0);
  switch (request.code) {
    case Operation::get_storage_ids:
      return {Response::ok, {}, DatasetWriter().u32(1).u32(Card::kStorage).take()};
    case Operation::get_storage_info:
      return card_.storage_info(first);
    case Operation::get_num_objects:
      return card_.count(first, request.parameter(1), request.parameter(2));
    case Operation::get_object_handles:
      return card_.handles(first, request.parameter(1), request.parameter(2));
    case Operation::get_object_info:
      return card_.info(first);
    case Operation::get_object: {
      Answer answer = card_.read(first, 0, std::numeric_limits<std::uint64_t>::max());
      answer.parameters.clear();
      return answer;
    }
    case Operation::get_partial_object:
      return card_.read(first, request.parameter(1), request.parameter(2));
    case Operation::delete_object:
      return only(card_.remove(first));
    default:
      return only(Response::operation_not_supported);
  }
}

bool Responder::take_capture() { return std::exchange(capture_, false); }

}  // namespace strobe::sim::ptp
