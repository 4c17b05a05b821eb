// Outputs of models whose plant is sized by coincident loads: the engine reports the design days before the run itself.

#include <gtest/gtest.h>

#include <fstream>

#include "sim/energyplus/replay/eso.hpp"
#include "support/complaint.hpp"
#include "support/program.hpp"

namespace airside::sim {
namespace {

constexpr const char* two_periods =
    "Program Version,EnergyPlus\n"
    "1,5,Environment Title[],Latitude[deg],Longitude[deg],Time Zone[],Elevation[m]\n"
    "2,8,Day of Simulation[],Month[],Day of Month[],DST Indicator[1=yes 0=no],Hour[],StartMinute[],EndMinute[],Day\n"
    "7,1,CORE,Zone Mean Air Temperature [C] !TimeStep\n"
    "End of Data Dictionary\n"
    "1,CHICAGO ANN CLG,41.77,-87.75,-6.00,190.00\n"
    "2,1,7,21,0,1,0,10,SummerDesignDay\n"
    "7,31.5\n"
    "1,AIRSIDE DAYS,41.77,-87.75,-6.00,190.00\n"
    "2,1,7,5,0,1,0,10,Monday\n"
    "7,23.5\n"
    "7,23.75\n"
    "End of Data\n";

TEST(EngineOutputs, OfSeveralPeriodsTheLastIsKept) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "eplusout.eso") << two_periods;
  const EsoFile last(folder.path() / "eplusout.eso", EsoFile::Periods::last);
  EXPECT_EQ(last.of("Core,Zone Mean Air Temperature"), (std::vector<double>{23.5, 23.75}));
}

TEST(EngineOutputs, OfSeveralPeriodsNoneIsTakenWhereOneIsExpected) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "eplusout.eso") << two_periods;
  hal::expect_complaint({"eplusout.eso", "more than one run period", "one EnergyPlus run", "again"},
                        [&] { EsoFile(folder.path() / "eplusout.eso"); });
}

}  // namespace
}  // namespace airside::sim
