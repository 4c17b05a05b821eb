# Puts sim/rooms/*.json into the library, so that programs find the rooms wherever they are installed.
file(GLOB room_files CONFIGURE_DEPENDS ${CMAKE_CURRENT_LIST_DIR}/*.json)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${room_files})
set(entries "")
set(room_count 0)
foreach(room_file ${room_files})
  get_filename_component(room_name ${room_file} NAME_WE)
  file(READ ${room_file} room_text)
  string(APPEND entries "    EmbeddedRoom{\"${room_name}\", R\"json(${room_text})json\"},\n")
  math(EXPR room_count "${room_count} + 1")
endforeach()
set(generated ${CMAKE_CURRENT_BINARY_DIR}/embedded_rooms.cpp)
file(CONFIGURE OUTPUT ${generated} @ONLY CONTENT "// Made from sim/rooms/*.json at configure time.
#include \"sim/rc/rc_room_file.hpp\"

namespace airside::sim {
namespace {
constexpr EmbeddedRoom rooms[] = {
@entries@};
}  // namespace
std::span<const EmbeddedRoom> embedded_rooms() { return rooms; }
}  // namespace airside::sim
")
target_sources(airside_sim PRIVATE ${generated})
