// Corrections over HTTP: see host/web/README.md. A preview says what they would make of a shot, and writes
// nothing. Saving and taking back write into the session's digitizations/, just as `strobe shot --edit` and
// --undo-edit do. Reads files; thread-safe, one at a time.
#pragma once

#include <functional>
#include <mutex>
#include <string>

#include "host/archive/redigitize.hpp"
#include "host/web/archive_routes.hpp"
#include "host/web/bounded_cache.hpp"
#include "host/web/http/event_hub.hpp"
#include "host/web/http/message.hpp"
#include "host/web/session_folders.hpp"

namespace strobe::web {

struct Preview {
  host::Shot shot;               ///< with the corrected digitization as its newest, and the result of that
  digitize::Digitization found;  ///< likewise, as measured
  digitize::DigitizeSettings settings;
  std::string light;  ///< what is not well with the photograph's, for a person
};

/// Keeps the automatic measurement of the shots looked at last, so that a change is seen at once.
class Previewer {
 public:
  /// corrections: a text as of --edit; file_name: for messages. The numbers are those that saving it gives.
  /// Refused with 422 and one line that names what is wrong with the corrections, with 409 where the
  /// photograph cannot be measured.
  Answered<Preview> preview(const host::StoredSession& session, const host::Shot& shot,
                            const std::string& corrections, const std::string& file_name);
  /// Without corrections: as it was found.
  Answered<Preview> automatic(const host::StoredSession& session, const host::Shot& shot);

  static constexpr std::size_t kMaxKept = 8;

 private:
  struct Key {
    std::filesystem::path photograph;
    FileStamp stamp;
    ShotKey shot;
    auto operator<=>(const Key&) const = default;
  };
  struct Measured {
    digitize::Digitization found;
    digitize::DigitizeSettings settings;
    std::string light;
  };
  Answered<Measured> measured(const host::StoredSession& session, const host::Shot& shot);

  std::mutex mutex_;
  BoundedCache<Key, Measured> kept_{kMaxKept};
};

/// What the routes keep; it must outlive the router.
struct Editing {
  /// archive and hub must outlive this. author: who corrects, and when.
  Editing(Archive& its_archive, EventHub& its_hub,
          std::function<host::Author()> its_author = host::author_now)
      : archive(its_archive), hub(its_hub), author(std::move(its_author)) {}

  Archive& archive;
  EventHub& hub;
  std::function<host::Author()> author;
  Previewer previews;
  std::mutex changing;
};

void add_editing_routes(Router& router, Editing& editing);

}  // namespace strobe::web
