#pragma once
// What is shown of the stored month: curves of at most 500 points, sums by day and by who controlled, and all rows.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "firmware/page/data/trend_store.hpp"

namespace airside::page {

constexpr std::size_t max_points = 500;

/// Rows of `day`, `week` or `month` (31 days); nothing for another word.
std::optional<std::uint64_t> rows_of_span(std::string_view span);

/// {span, from, to, step_s, points, time_s, held_degc, .., rooms_degc, mode, spells, days, by_control, reading,
/// trouble}. A point is the mean of its rows, its mode the gravest of them; what nobody logged is null. `of_band`: the
/// site has no target, so there are no degree-hours from it. Instead each sum has the zones' degree-hours above their
/// cooling setpoint + comfort_slack_k and below their heating setpoint - comfort_slack_k, and `zones` their setpoints
/// by the newest row: {time, cooling_degc, heating_degc}. Cost: some ms for a month.
nlohmann::json trends(const TrendStore& store, std::string_view span, bool of_band);

/// Header and rows for /trends.csv, rounded for people: temperatures to 0.01 degC, power to 0.001 kW.
std::string trends_csv_header(const TrendStore& store);
void append_csv_row(const TrendStore& store, std::uint64_t number, std::string& out);

}  // namespace airside::page
