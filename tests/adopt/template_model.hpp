#pragma once
// Two rooms and a packaged VAV unit in the engine's template language, as a person writes it.

namespace airside::tools {

inline constexpr const char* template_model = R"(
Version,25.2;
Timestep,6;
Building,Werkstatt,0,City,0.04,0.4,FullExterior,25,6;
GlobalGeometryRules,UpperLeftCorner,CounterClockWise,World;
Site:Location,Chicago,41.98,-87.92,-6,201;
SimulationControl,Yes,Yes,No,No,Yes;
RunPeriod,Year,1,1,,12,31,,,,,,,;
SizingPeriod:DesignDay,Summer,7,21,SummerDesignDay,33.3,10.7,,,Wetbulb,23.7,,,,,98934,4.9,230,No,No,No,ASHRAEClearSky,,,,,1;
SizingPeriod:DesignDay,Winter,1,21,WinterDesignDay,-20,0,,,Wetbulb,-20,,,,,98934,4.9,270,No,No,No,ASHRAEClearSky,,,,,0;
ScheduleTypeLimits,Any;
Schedule:Compact,Immer,Any,Through: 12/31,For: AllDays,Until: 24:00,1;
Schedule:Compact,Bürozeit,Any,Through: 12/31,For: Weekdays,Until: 7:00,0,Until: 18:00,1,Until: 24:00,0,For: AllOtherDays,Until: 24:00,0;
Schedule:Compact,Fleiß,Any,Through: 12/31,For: AllDays,Until: 24:00,120;
Material,Brick,Rough,0.2,0.7,1800,840;
Construction,Wall,Brick;
Zone,Raum Süd;
Zone,Raum Nord;
BuildingSurface:Detailed,S1,Wall,Wall,Raum Süd,,Outdoors,,SunExposed,WindExposed,,4,0,0,3,0,0,0,6,0,0,6,0,3;
BuildingSurface:Detailed,S2,Floor,Wall,Raum Süd,,Adiabatic,,NoSun,NoWind,,4,0,6,0,6,6,0,6,0,0,0,0,0;
BuildingSurface:Detailed,N1,Wall,Wall,Raum Nord,,Outdoors,,SunExposed,WindExposed,,4,6,12,3,6,12,0,0,12,0,0,12,3;
BuildingSurface:Detailed,N2,Floor,Wall,Raum Nord,,Adiabatic,,NoSun,NoWind,,4,0,12,0,6,12,0,6,6,0,0,6,0;
People,Leute Süd,Raum Süd,Bürozeit,People,3,,,0.3,,Fleiß;
People,Leute Nord,Raum Nord,Bürozeit,People,3,,,0.3,,Fleiß;
ElectricEquipment,Geräte,Raum Süd,Bürozeit,EquipmentLevel,600;
HVACTemplate:Thermostat,Alle,,20,,24;
HVACTemplate:Zone:VAV,Raum Süd,Anlage 1,Alle,autosize,,,Constant,0.2,,,Flow/Person,0.00944,,,Electric;
HVACTemplate:Zone:VAV,Raum Nord,Anlage 1,Alle,autosize,,,Constant,0.2,,,Flow/Person,0.00944,,,None;
HVACTemplate:System:PackagedVAV,Anlage 1,Bürozeit;
)";

}  // namespace airside::tools
