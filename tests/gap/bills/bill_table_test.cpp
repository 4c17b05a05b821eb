// Bills as people copy them, and what is said of those that are wrong.

#include "tools/gap/bills/bill_table.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "hal/text/input_error.hpp"
#include "sim/weather/weather.hpp"

namespace airside::tools::gap {
namespace {

const std::vector<std::string> billed_meters{"grid kWh", "gas kWh"};

BillTable bills_of_text(const std::string& text) { return parse_bills(text, "bills.csv", billed_meters); }

TEST(BillTable, ReadsPeriodsAndMetersInAnyOrderOfColumns) {
  const BillTable t = bills_of_text(
      "gas kWh, from ,to,note,grid kWh\r\n"
      "12.5,2021-01-01,2021-01-31,cold,900\n\n"
      ",2021-02-01,2021-02-28,,850.25");
  EXPECT_EQ(t.meters, billed_meters);
  ASSERT_EQ(t.periods.size(), 2U);
  EXPECT_EQ(t.periods[0].days(), 31) << "the last day is part of the bill";
  EXPECT_EQ(t.periods[1].to, sim::civil_midnight(2021, 3, 1));
  EXPECT_EQ(t.kwh(0, 0), 900);
  EXPECT_EQ(t.kwh(0, 1), 12.5);
  EXPECT_EQ(t.kwh(1, 0), 850.25);
  EXPECT_TRUE(std::isnan(t.kwh(1, 1))) << "no bill";
}

TEST(BillTable, TakesTheMetersThatHaveAColumn) {
  const BillTable t = bills_of_text("from,to,grid kWh\n2021-01-01,2021-12-31,1\n");
  EXPECT_EQ(t.meters, std::vector<std::string>{"grid kWh"});
  EXPECT_EQ(t.periods[0].days(), 365);
}

TEST(BillTable, SaysWhereAndWhatIsWrong) {
  const struct {
    const char *text, *place, *found;
  } wrong[] = {
      {"", "bills.csv: ", "no bill"},
      {"from,to,grid kWh\n", "bills.csv: ", "no bill"},
      {"from,grid kWh\n2021-01-01,5\n", "bills.csv:1: header", "a column to"},
      {"from,to,power\n", "bills.csv:1: header", "grid kWh, gas kWh"},
      {"from,to,grid kWh\n2021-13-01,2021-01-31,5\n", "bills.csv:2: from", "2021-13-01"},
      {"from,to,grid kWh\n2021-01-01,,5\n", "bills.csv:2: to", "nothing"},
      {"from,to,grid kWh\n2021-01-01,2021-01-31,5 kWh\n", "bills.csv:2: grid kWh", "5 kWh"},
      {"from,to,grid kWh\n2021-01-01,2021-01-31,-5\n", "bills.csv:2: grid kWh", "-5"},
      {"from,to,grid kWh\n2021-01-01,2021-01-31\n", "bills.csv:2: line", "2 fields"},
      {"from,to,grid kWh\n2021-02-01,2021-01-31,5\n", "bills.csv:2: to", "not before the first"},
      {"from,to,grid kWh\n2021-12-01,2022-01-31,5\n", "bills.csv:2: to", "one calendar year"},
      {"from,to,grid kWh\n2021-01-01,2021-01-31,5\n2021-01-31,2021-02-28,5\n", "bills.csv:3: from", "after 2021-01-31"},
      {"from,to,grid kWh\n2021-01-01,2021-01-31,\n", "bills.csv: ", "no bill"},
  };
  for (const auto& w : wrong) {
    try {
      bills_of_text(w.text);
      ADD_FAILURE() << w.text;
    } catch (const hal::InputError& e) {
      EXPECT_EQ(std::string(e.what()).rfind(w.place, 0), 0U) << e.what();
      EXPECT_NE(std::string(e.what()).find(w.found), std::string::npos) << e.what();
    }
  }
}

}  // namespace
}  // namespace airside::tools::gap
