// Corrections over HTTP: see host/web/README.md. Saving and taking back write into the session's digitizations/, just as
// `strobe shot --edit` and --undo-edit do, one at a time.
#pragma once

#include <functional>
#include <mutex>

#include "host/archive/redigitize.hpp"
#include "host/web/archive/archive_routes.hpp"
#include "host/web/editing/preview.hpp"
#include "host/web/http/event_hub.hpp"

namespace strobe::web {

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
