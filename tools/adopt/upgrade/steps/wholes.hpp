#pragma once
// Changes of an IDF that concern several objects at once, or one object in another order.

#include <vector>

#include "tools/adopt/upgrade/table/change.hpp"

namespace airside::tools::upgrade {

/// To 9.0: a run period has years and is not repeated; shading controls name their windows, not windows their control.
void run_periods_and_shading(IdfText& idf, std::vector<Refusal>& refused);
/// To 9.1: two fields more for each piece of equipment of a zone.
void wider_equipment_lists(IdfText& idf, std::vector<Refusal>& refused);
/// To 9.2: fractions of equipment lists are schedules, and run periods have names.
void fractions_and_names(IdfText& idf, std::vector<Refusal>& refused);
/// To 9.3: an uncontrolled terminal is one of constant volume in an air distribution unit; shadows have a method.
void terminals_and_shadows(IdfText& idf, std::vector<Refusal>& refused);
/// To 9.4: one Output:Diagnostics for all keys.
void one_diagnostics(IdfText& idf, std::vector<Refusal>& refused);
/// To 24.1: effectiveness at 75 % of flow is a table.
void heat_recovery_tables(IdfText& idf, std::vector<Refusal>& refused);

}  // namespace airside::tools::upgrade
