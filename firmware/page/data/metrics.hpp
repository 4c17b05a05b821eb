#pragma once
// The status as Prometheus reads it.

#include <string>

#include "firmware/page/data/state_folder.hpp"

namespace airside::page {

/// Text exposition format 0.0.4. Without a status only `airside_up 0` and the page's own numbers.
std::string metrics_text(const StatusReader& status);

}  // namespace airside::page
