// What strobe and a camera's driver say to each other. A driver is a program of its own, so that a library
// or a camera that misbehaves takes neither host nor series with it: strobe starts it, writes requests to its
// standard input and reads events from its standard output, one JSON object a line. It ends when its input
// does. Times are those of this machine's CLOCK_MONOTONIC. Values; thread-safe; allocates.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "common/result.hpp"
#include "common/units/time.hpp"

namespace strobe::tether {

struct CameraIdentity {
  std::string vendor, model, serial, firmware;
  std::string address;  ///< IP address, or libgphoto2's port, such as usb:001,004
};

/// What became of a setting.
enum class SettingState {
  as_asked,
  rounded,  ///< the camera took another value than was asked for
  refused,  ///< it kept its own
  absent,   ///< it has no such setting
  read,     ///< not asked for; for the record
};

/// A setting by the camera's own name for it: GenICam's feature (SFNC) or libgphoto2's.
struct Setting {
  std::string name;
  std::string asked;  ///< empty where it was only read
  std::string is;     ///< as read back
  SettingState state = SettingState::read;
  std::string remark;  ///< for a person
};

/// What spoils photographs, with what mends it, for a person.
struct Problem {
  bool prevents = false;  ///< nothing is to be fired with it
  std::string text;
};

/// What is sent to a driver.
struct ListRequest {};
struct OpenRequest {
  std::string serial;                      ///< empty: the only one there is
  std::string address;                     ///< where to look; empty: everywhere
  bool exposure_by_line = true;            ///< while the shutter line is active, else of exposure_s
  double exposure_s = 0.5;                 ///< in the latter case, 1e-6 to 3600
  std::map<std::string, std::string> set;  ///< in place of the driver's own, by the camera's names
  std::string folder;                      ///< where photographs are put, renamed when whole
  bool delete_from_camera = false;
};
/// Takes one picture at once, without the line.
struct SnapRequest {
  double exposure_s = 0.01;  ///< 1e-6 to 3600
};
/// Whether the camera answers now: ReadyEvent, or GoneEvent.
struct CheckRequest {};
using Request = std::variant<ListRequest, OpenRequest, SnapRequest, CheckRequest>;

/// What a driver tells.
struct CamerasEvent {
  std::vector<CameraIdentity> cameras;
};
/// A camera is ready; again when one that was gone is back, and when its settings have changed.
struct OpenedEvent {
  CameraIdentity camera;
  std::string exposure;    ///< how it exposes, for a person
  bool has_clock = false;  ///< photographs come with the instant of their exposure
  std::vector<Setting> settings;
  std::vector<Problem> problems;
};
/// The camera that is open has answered just now.
struct ReadyEvent {};
/// When the camera itself says that an exposure began.
struct ExposureStart {
  HostTime instant;
  Duration sd{};  ///< of the relation of the camera's clock to this machine's, > 0
};
/// A photograph has been put into the folder.
struct PhotographEvent {
  std::string file;          ///< its name
  std::int64_t number = -1;  ///< the camera's count; -1: it does not count
  std::optional<ExposureStart> exposed;
  std::int64_t packets_resent = 0;
};
/// There was an exposure of which there is no photograph.
struct LostEvent {
  std::int64_t number = -1;
  std::optional<ExposureStart> exposed;
  std::string why;
};
/// The camera does not answer any more; the driver goes on looking for it.
struct GoneEvent {
  std::string why;
};
/// A request could not be done.
struct FailedEvent {
  std::string why;
};
/// A line for a person.
struct NoteEvent {
  std::string text;
};
using Event = std::variant<CamerasEvent, OpenedEvent, ReadyEvent, PhotographEvent, LostEvent, GoneEvent,
                           FailedEvent, NoteEvent>;

/// One line, without its end.
std::string to_line(const Request& request);
std::string to_line(const Event& event);

/// Fails with one line that names the field.
Result<Request> parse_request(std::string_view line);
Result<Event> parse_event(std::string_view line);

std::string_view name(SettingState state);

}  // namespace strobe::tether
