# 32-bit ARM Linux with hardware floating point, Debian's cross compiler (g++-arm-linux-gnueabihf); programs run here
# under qemu-arm.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR armv7l)
set(CMAKE_CXX_COMPILER arm-linux-gnueabihf-g++)
set(CMAKE_LIBRARY_ARCHITECTURE arm-linux-gnueabihf)
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-arm -L /usr/arm-linux-gnueabihf)
add_compile_options(-Wno-psabi)  # a note on an ABI change of GCC 7 is no warning about this code
# A box outlives 2038: time_t has 64 bits, and so has off_t.
add_compile_definitions(_TIME_BITS=64 _FILE_OFFSET_BITS=64)
