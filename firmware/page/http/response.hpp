#pragma once
// Answers of airside-page as libmicrohttpd takes them.

#include <microhttpd.h>

#include <string>
#include <string_view>

#include "firmware/page/http/refusals.hpp"
#include "firmware/page/http/static_files.hpp"

namespace airside::page {

/// Markup cannot be in a JSON text whose angle brackets are escaped; outside of its strings there are none.
std::string without_markup(std::string_view json);

/// A body of this text.
MHD_Response* response_of(const std::string& text);

/// `{"status":422,"code":"weights_cycle","reason":"...","field":"cycle_min","found":"18","expected":"30"}`, without
/// what is empty.
MHD_Response* json_of(const Said& said);

/// Adds the header lines that every answer has: JSON unless said otherwise, the connection's end, and what keeps
/// browsers from running, framing or keeping it. What already has a Content-Security-Policy or Cache-Control keeps it.
void add_common_lines(MHD_Response* response);

/// A file of the page, which may run its own scripts and nothing else; where the browser has it already
/// (`if_none_match` names its ETag) only that is said: `status` becomes 304. Packed where `accept_encoding` has gzip
/// without a weight of 0.
MHD_Response* asset_of(const StaticFile& file, const char* if_none_match, const char* accept_encoding, int& status);

}  // namespace airside::page
