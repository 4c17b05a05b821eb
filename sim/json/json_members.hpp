#pragma once
// Members of a JSON object as text, for large files of which a reader needs little.

#include <string>
#include <string_view>
#include <vector>

namespace airside::sim {

/// One member of an object, as the text has it.
struct JsonMember {
  std::string_view key;    ///< between its quotes; escapes are not resolved
  std::string_view value;  ///< whole: with its brackets or quotes, without blanks around it
};

/// The members of the object that `text` is, in its order. Only brackets and quotes are looked at: whoever needs a
/// value parses it, and learns then whether it is JSON. Cost: one pass, about a nanosecond a byte, where the parser of
/// parse_json() takes 30. Errors: hal::InputError named `place` where the text is no object or ends within it.
std::vector<JsonMember> json_members(std::string_view text, const std::string& place);

}  // namespace airside::sim
