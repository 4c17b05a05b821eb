#pragma once
// A model of an older EnergyPlus brought to the engine's version, step by step by the tables in steps/.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace airside::tools {

/// Objects of one type that an upgrade changed.
struct UpgradedType {
  std::string type;
  int objects = 0;
  std::string versions;  ///< the steps that changed them: "9.3, 9.6"
};

/// What an upgrade did; empty versions where there was none.
struct Upgrade {
  std::string from, to;
  std::string programs;  ///< the folder of the Transition programs that did it; empty: the tables here
  std::vector<UpgradedType> types;
  int objects() const;
};

/// "upgraded from EnergyPlus 9.0 to 25.2: 52 objects of 9 types"; empty where nothing was.
std::string text_of(const Upgrade& done);

/// "25.2" of "25.2.0".
std::string short_version(const std::string& version);
/// Whether version `a` comes before `b`, both short.
bool is_older(const std::string& a, const std::string& b);
/// The oldest version that the tables know.
std::string oldest_version();
/// Whether the tables lead from one version to another.
bool tables_lead(const std::string& from, const std::string& to);

/// An IDF of version `from` as one of version `to`, both short.
/// Errors: hal::InputError for an IDF that does not end, and for objects that a step changes in a way that the tables
///   do not follow: the place of the first, how many there are, the step, what else upgrades it.
/// Cost: 15 steps 0.1 s for 10,000 objects.
std::string upgraded_idf(const std::string& text, const std::string& place, const std::string& from,
                         const std::string& to, Upgrade& done);

/// The same for an epJSON; only names of fields, words and types change in it.
/// Errors: as upgraded_idf(), and for types whose objects changed their shape in epJSON.
void upgrade_epjson(nlohmann::json& model, const std::string& place, const std::string& from, const std::string& to,
                    Upgrade& done);

}  // namespace airside::tools
