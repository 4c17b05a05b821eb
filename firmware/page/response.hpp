#pragma once
// Answers of airside-page as libmicrohttpd takes them.

#include <microhttpd.h>

#include <string>
#include <string_view>

namespace airside::page {

/// Markup cannot be in a JSON text whose angle brackets are escaped; outside of its strings there are none.
std::string without_markup(std::string_view json);

/// A body of this text.
MHD_Response* response_of(const std::string& text);

/// `{"status":404,"reason":"..."}`.
MHD_Response* json_of(int status, std::string_view reason);

/// Adds the header lines that every answer has: JSON unless said otherwise, the connection's end, and what keeps
/// browsers from running, framing or keeping it.
void add_common_lines(MHD_Response* response);

}  // namespace airside::page
