// An earlier verdict beside this one.

#include <fmt/format.h>

#include "tools/gap/report/gap_page.hpp"

namespace airside::tools {

void add_continued(const GapPage& page, ReportInput& input) {
  const std::vector<gap::CandidateBeforeAfter> candidates = gap::candidates_before_after(page.run);
  if (candidates.empty()) return;
  ReportTable table;
  table.title = "What the further days have changed";
  table.note =
      as_sentence(gap::continued_text(page.run)) +
      " Gain of each candidate: twice the logarithm of the likelihood that it adds, by simulation where it was "
      "simulated. Curves show the days one after another, those with a test first; their dates are of the first "
      "stretch.";
  table.row_header = "candidate";
  table.columns = {{"gain before", "", 0, false}, {"gain now", "", 0, false}, {"limit", "", 0, false}};
  for (const gap::CandidateBeforeAfter& c : candidates) {
    const bool found = page.found() && page.run.verdict.findings.front().at.id() == c.id;
    table.rows.push_back({effect_title(page, c.id),
                          {number_cell(c.before), number_cell(c.after), number_cell(c.limit)},
                          found ? SeriesRole::main : SeriesRole::plain,
                          false});
  }
  input.blocks.push_back(table);
}

}  // namespace airside::tools
