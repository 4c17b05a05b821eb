#pragma once
// Rooms from JSON: each file names a base room and the fields that differ from it. The project's own rooms are part
// of the program; a path brings the user's.

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/rc/rc_room.hpp"

namespace airside::sim {

/// A room file compiled in.
struct EmbeddedRoom {
  std::string_view name, json;
};
std::span<const EmbeddedRoom> embedded_rooms();

/// Names that load_room knows: "rc" and the embedded ones.
std::vector<std::string> room_names();

/// Room by name ("rc", "701", "701-real") or by path (ends in ".json").
/// Errors: hal::InputError naming file and field: unknown name, field or base, wrong type, count or range.
RcRoom load_room(const std::string& name_or_path);

/// Room from the text of a file; `place` is named in messages, `name` becomes the room's.
/// Keys: "base" (default "rc"), "about", "seed", "vavs"/"fcus"/"powers" (only on base "rc"), "perturb_seed", and the
/// fields of room_fields(): a number, or for repeating fields a list or one number for all.
/// Errors: as load_room.
RcRoom parse_room(const std::string& json_text, const std::string& place, const std::string& name);

}  // namespace airside::sim
