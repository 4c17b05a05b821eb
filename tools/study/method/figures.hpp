#pragma once
// Figures and peers' tables of the page of the published method's studies. Each is nothing where no run is there.

#include <optional>
#include <string>

#include "tools/report/charts/report_input.hpp"
#include "tools/study/method/peer_rows.hpp"
#include "tools/study/method/results.hpp"

namespace airside::tools {

/// A column of a table of the page.
TableColumn table_column(const std::string& name, const std::string& unit, int decimals, bool mark_lowest);

/// Printed figure 7: DAE day by day of the method and what it is compared with, degC.
std::optional<ReportBlock> figure_of_days(const MethodResults& results, const PeerRows& peers);
/// Printed figure 8: DAE and DARV over the controlled days, degC.
std::optional<ReportBlock> figure_of_two_weeks(const MethodResults& results, const PeerRows& peers);
/// Printed figure 9: DAE day by day while the agent learns in the twin, degC.
std::optional<ReportBlock> figure_of_pretraining(const MethodResults& results);
/// Printed figure 10: DAE and DARV by length of the control cycle, degC.
std::optional<ReportBlock> figure_of_cycles(const MethodResults& results);
/// Printed figure 11: area saved against the historical setpoint, degC h a day.
std::optional<ReportBlock> figure_of_saved_area(const MethodResults& results);
/// Printed figure 12: DAE day by day in a room, transferred and not, degC.
std::optional<ReportBlock> figure_of_transfer(const MethodResults& results, const std::string& room);
/// Printed figure 13: DAE day by day in a neighbour of room 301, degC.
std::optional<ReportBlock> figure_of_neighbours(const MethodResults& results, const std::string& room);
/// Printed table VII and the methods of figures 7 and 8, from the peers' own harness.
std::optional<ReportBlock> peers_table(const PeerRows& peers);
/// Printed tables III and VI: errors of transferred networks with frozen weights, K.
std::optional<ReportBlock> transfer_table(const PeerRows& peers);

}  // namespace airside::tools
