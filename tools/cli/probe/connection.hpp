#pragma once
// Whether the AHU's controller can be reached at all, in words, where it cannot.

#include <optional>
#include <string>

#include "hal/site/site_file.hpp"

namespace airside::tools {

/// Why no connection comes about, and what to try.
struct NoConnection {
  std::string found, remedy;
};

/// Connects once, or looks at the serial line, and speaks no Modbus. Nothing where that is in order. The site needs
/// [modbus]. Cost: at most 3 s beside looking up a name.
std::optional<NoConnection> why_no_connection(const hal::SiteFile& site);

}  // namespace airside::tools
