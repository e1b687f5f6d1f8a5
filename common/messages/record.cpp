#include "common/messages/record.hpp"

#include <algorithm>
#include <strobe_msgs/note_t.hpp>

namespace strobe::messages {

bool valid_note_key(std::string_view key) {
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '.';
  };
  return !key.empty() && key.size() <= kLongestNoteKey && std::all_of(key.begin(), key.end(), allowed);
}

std::vector<strobe_msgs::note_t> notes_from_record(const reduction::Record& record) {
  std::vector<strobe_msgs::note_t> notes;
  notes.reserve(record.size());
  for (const auto& [key, value] : record) {
    strobe_msgs::note_t note;
    note.key = key;
    note.value = value;
    notes.push_back(std::move(note));
  }
  return notes;
}

Result<reduction::Record> record_from_notes(const std::vector<strobe_msgs::note_t>& notes) {
  if (notes.size() > kMaxNotes) return fail("notes: at most " + std::to_string(kMaxNotes) + " are allowed");
  reduction::Record record;
  for (std::size_t i = 0; i < notes.size(); ++i) {
    const std::string place = "notes[" + std::to_string(i) + "].";
    if (!valid_note_key(notes[i].key))
      return fail(place + "key: must be 1 to 64 characters of a-z, 0-9, _ and .");
    if (notes[i].value.size() > kLongestNoteValue) return fail(place + "value: must be at most 1024 bytes");
    record[notes[i].key] = notes[i].value;
  }
  return record;
}

}  // namespace strobe::messages
