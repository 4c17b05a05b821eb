#pragma once
// The table [stand_in] of a site file.

#include <string>

#include "hal/points/stand_ins.hpp"
#include "hal/text/toml_section.hpp"

namespace airside::hal {

/// Reads it for a site of a topology such as `5vav-5fcu-2power`; without the table there are none.
/// Errors: InputError for a name that the site has no signal of, for one that needs a sensor, for a value that is none
/// of its kind.
StandIns read_stand_ins(TomlSection table, const std::string& topology);

}  // namespace airside::hal
