# A microcontroller without an operating system: Cortex-M7 with double-precision FPU, gcc-arm-none-eabi and newlib.
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR cortex-m7)
set(CMAKE_CXX_COMPILER arm-none-eabi-g++)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
set(cpu -mcpu=cortex-m7 -mthumb -mfloat-abi=hard -mfpu=fpv5-d16)
# Not CMAKE_CXX_FLAGS_INIT: a preset that sets CMAKE_CXX_FLAGS would silently drop it.
add_compile_options(${cpu} -ffunction-sections -fdata-sections -Wno-psabi)
add_link_options(${cpu})
