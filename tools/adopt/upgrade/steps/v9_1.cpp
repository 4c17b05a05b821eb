// What EnergyPlus 9.1 changed in the input of 9.0.

#include "tools/adopt/upgrade/steps/steps.hpp"
#include "tools/adopt/upgrade/steps/wholes.hpp"

namespace airside::tools::upgrade {

namespace {

constexpr Change changes_9_1[] = {
    insert("HybridModel:Zone", 5),
    insert("HybridModel:Zone", 7, 10),
    refuse("FaultModel:PressureSensorOffset:OutdoorAir", "there is no such object any more"),
};

constexpr const char* whole_types_9_1[] = {"PlantEquipmentList", "CondenserEquipmentList"};

}  // namespace

Step step_to_9_1() { return {"9.0", "9.1", changes_9_1, wider_equipment_lists, whole_types_9_1}; }

}  // namespace airside::tools::upgrade
