#include "firmware/edge/report/row_report.hpp"

#include "airside/civil_time.hpp"
#include "firmware/edge/report/say.hpp"

namespace airside::edge {

void say_watchdog(double given_s) {
  constexpr double least_s = 2.0 * row_s;
  if (given_s <= 0 || given_s > least_s) return;
  say("the unit's WatchdogSec is {} s, and a row comes each {} s; set it above {} s", given_s, row_s, least_s);
}

void RowReport::say_doubted(const hal::Point* doubted) {
  if (doubted != nullptr && doubted->name != said_doubted_) {
    say("{}: its words make sense only in another order; airside probe shows which", doubted->name);
  }
  said_doubted_ = doubted != nullptr ? std::string_view(doubted->name) : std::string_view{};
}

void RowReport::say_mode(const ActiveMode& on, std::string_view storage_remedy) {
  if (on == said_mode_) return;
  if (on.reason == Reason::storage_failed && !storage_remedy.empty()) {
    say("{}: {}; ends with the first write that succeeds; {}", text_of(on.mode), why_of(on), storage_remedy);
  } else {
    say("{}: {}; {}", text_of(on.mode), why_of(on), way_out_of(on));
  }
  said_mode_ = on;
}

}  // namespace airside::edge
