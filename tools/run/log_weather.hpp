#pragma once
// The weather file that lies beside a simulated log.

#include <string>
#include <vector>

namespace airside::tools {

/// NAME.epw of NAME.csv, where `simulate --log` puts the weather that it made up.
std::string weather_beside(const std::string& log);

/// The weather file that lies beside these logs; "" where none has one. Empty names are passed over.
/// Errors: hal::InputError where two of them have lived in different weather.
std::string weather_of_logs(const std::vector<std::string>& logs);

}  // namespace airside::tools
